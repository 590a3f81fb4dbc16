//! Golden hashes of results per instruction set (`tests/golden/bits.csv`), for tests.

#[doc(hidden)]
#[cfg(any(test, feature = "test-support"))]
pub mod golden {
    use std::path::PathBuf;
    use std::process::Command;
    use std::sync::{Mutex, OnceLock};

    use super::super::Isa;

    /// Environment variable that names the instruction set of a test process.
    const ISA_VARIABLE: &str = "NEURAL_MESH_TEST_INSTRUCTIONS";
    /// Environment variable; `write` adds missing hashes to the file.
    const WRITE_VARIABLE: &str = "NEURAL_MESH_GOLDEN";
    const HASH_PREFIX: &str = "golden hash: ";

    static FORCED_ISA: OnceLock<Isa> = OnceLock::new();

    pub(crate) fn forced_isa() -> Option<Isa> {
        FORCED_ISA.get().copied()
    }

    /// Names of results, each with a hash of its bits.
    #[doc(hidden)]
    pub type Results = Vec<(String, u64)>;

    #[doc(hidden)]
    pub struct GoldenCheck {
        pub part: &'static str,
        pub version: u32,
        pub constant: &'static str,
        /// Path of the test that calls [`check`], run in one process per instruction set.
        pub test: &'static str,
    }

    /// Panics if results differ in bits from the file, on any instruction set of this processor.
    #[doc(hidden)]
    pub fn check(golden: &GoldenCheck, results: fn() -> Results) {
        if let Ok(name) = std::env::var(ISA_VARIABLE) {
            let isa = Isa::available().into_iter().find(|isa| isa.name() == name);
            FORCED_ISA.get_or_init(|| isa.expect("this processor has these instructions"));
            results().iter().for_each(|(name, hash)| println!("{HASH_PREFIX}{name} {hash:016x}"));
            return;
        }
        // Functions such as `exp` are the system's, which differ in bits.
        if !cfg!(all(target_arch = "x86_64", target_os = "linux", target_env = "gnu")) {
            println!("no golden hashes for this system: nothing is compared");
            return;
        }
        let known = read();
        for isa in Isa::available() {
            compare(golden, isa, &run_in_process(golden, isa), &known);
        }
    }

    fn run_in_process(golden: &GoldenCheck, isa: Isa) -> Vec<(String, String)> {
        let mut test = Command::new(std::env::current_exe().unwrap());
        test.args([golden.test, "--exact", "--nocapture"]).env(ISA_VARIABLE, isa.name());
        let done = test.output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let out = String::from_utf8(done.stdout).unwrap();
        // The test's name may precede the first hash.
        let hashes = out.lines().filter_map(|line| line.split_once(HASH_PREFIX)?.1.rsplit_once(' '));
        let hashes: Vec<_> = hashes.map(|(name, hash)| (name.to_owned(), hash.to_owned())).collect();
        assert!(!hashes.is_empty(), "{} tells nothing: {out}", golden.test);
        hashes
    }

    fn compare(golden: &GoldenCheck, isa: Isa, found: &[(String, String)], known: &[[String; 5]]) {
        let GoldenCheck { part, version, constant, .. } = golden;
        let mut new = Vec::new();
        for (name, hash) in found {
            let row = [*part, &version.to_string(), isa.name(), name, hash].map(String::from);
            match known.iter().find(|other| other[..4] == row[..4]) {
                Some(other) => assert_eq!(
                    other[4],
                    *hash,
                    "{name} ({}): the bits have changed: give {constant} another number, write the hashes down \
                     ({WRITE_VARIABLE}=write) and make the measured pages again (neural-mesh-bench measure)",
                    isa.name()
                ),
                None => new.push(row),
            }
        }
        if std::env::var(WRITE_VARIABLE).is_ok_and(|wish| wish == "write") {
            write(part, *version, new);
        } else {
            let names: Vec<&str> = new.iter().map(|row| row[3].as_str()).collect();
            assert!(
                new.is_empty(),
                "no golden hashes of version {version} of {part}: {names:?}: {WRITE_VARIABLE}=write adds them"
            );
        }
    }

    fn path() -> PathBuf {
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/bits.csv")
    }

    fn read() -> Vec<[String; 5]> {
        let text = std::fs::read_to_string(path()).unwrap_or_default();
        let row = |line: &str| line.split(',').map(String::from).collect::<Vec<_>>().try_into().unwrap();
        text.lines().skip(1).map(row).collect()
    }

    fn write(part: &str, version: u32, new: Vec<[String; 5]>) {
        static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
        let _alone = ONE_AT_A_TIME.lock();
        let mut rows: Vec<[String; 5]> = read();
        rows.extend(new);
        rows.retain(|row| row[0] != part || row[1] == version.to_string());
        rows.sort();
        rows.dedup();
        let lines: Vec<String> = rows.iter().map(|row| row.join(",") + "\n").collect();
        std::fs::write(path(), format!("part,version,instructions,result,hash\n{}", lines.concat())).unwrap();
    }

    #[derive(Clone, Copy)]
    #[doc(hidden)]
    pub struct Hash(u64);

    impl Hash {
        #[doc(hidden)]
        pub fn new() -> Self {
            Self(0xcbf2_9ce4_8422_2325)
        }

        #[doc(hidden)]
        pub fn bytes(self, bytes: &[u8]) -> Self {
            Self(bytes.iter().fold(self.0, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)))
        }

        #[doc(hidden)]
        pub fn floats(self, floats: &[f32]) -> Self {
            floats.iter().fold(self, |hash, float| hash.bytes(&float.to_bits().to_le_bytes()))
        }

        #[doc(hidden)]
        pub fn indices(self, indices: &[u32]) -> Self {
            indices.iter().fold(self, |hash, index| hash.bytes(&index.to_le_bytes()))
        }

        #[doc(hidden)]
        pub fn value(self) -> u64 {
            self.0
        }
    }
}
