//! Golden hashes of results for every set of instructions, kept in `tests/golden/bits.csv`: what ties the version of a result to
//! its bits. There is nothing here but for tests.

#[cfg(test)]
pub(crate) mod golden {
    use std::path::PathBuf;
    use std::process::Command;
    use std::sync::{Mutex, OnceLock};

    use super::super::Isa;

    /// Names the instructions that a process of a test has to do with.
    const ASKED: &str = "NEURAL_MESH_TEST_INSTRUCTIONS";
    /// Set to `write`, adds what the file does not have.
    const WISH: &str = "NEURAL_MESH_GOLDEN";
    /// How a process tells a hash.
    const TOLD: &str = "golden hash: ";

    static FORCED: OnceLock<Isa> = OnceLock::new();

    /// The instructions that this process was told to do with.
    pub(crate) fn forced() -> Option<Isa> {
        FORCED.get().copied()
    }

    /// Results by name, each as a hash of its bits.
    pub(crate) type Results = Vec<(String, u64)>;

    /// What is tied: its name in the file, its version, the name of the constant that holds that, the test.
    pub(crate) struct Tied {
        pub part: &'static str,
        pub version: u32,
        pub constant: &'static str,
        /// Path of the test that calls [`check`]; each set of instructions has a process of its own that runs it.
        pub test: &'static str,
    }

    /// Panics where results of this version have other bits than those in the file, on any set of instructions that this
    /// processor has.
    pub(crate) fn check(tied: &Tied, results: fn() -> Results) {
        if let Ok(asked) = std::env::var(ASKED) {
            let isa = Isa::available().into_iter().find(|isa| isa.name() == asked);
            FORCED.get_or_init(|| isa.expect("this processor has these instructions"));
            results().iter().for_each(|(name, hash)| println!("{TOLD}{name} {hash:016x}"));
            return;
        }
        // Functions like the exponential are the system's.
        if !cfg!(all(target_arch = "x86_64", target_os = "linux", target_env = "gnu")) {
            println!("no golden hashes for this system: nothing is compared");
            return;
        }
        let known = read();
        for isa in Isa::available() {
            compare(tied, isa, &computed(tied, isa), &known);
        }
    }

    /// The hashes of a process of its own.
    fn computed(tied: &Tied, isa: Isa) -> Vec<(String, String)> {
        let mut test = Command::new(std::env::current_exe().unwrap());
        test.args([tied.test, "--exact", "--nocapture"]).env(ASKED, isa.name());
        let done = test.output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let out = String::from_utf8(done.stdout).unwrap();
        // The name of the test may stand before the first.
        let told = out.lines().filter_map(|line| line.split_once(TOLD)?.1.rsplit_once(' '));
        let told: Vec<_> = told.map(|(name, hash)| (name.to_owned(), hash.to_owned())).collect();
        assert!(!told.is_empty(), "{} tells nothing: {out}", tied.test);
        told
    }

    fn compare(tied: &Tied, isa: Isa, found: &[(String, String)], known: &[[String; 5]]) {
        let Tied { part, version, constant, .. } = tied;
        let mut new = Vec::new();
        for (name, hash) in found {
            let row = [*part, &version.to_string(), isa.name(), name, hash].map(String::from);
            match known.iter().find(|other| other[..4] == row[..4]) {
                Some(other) => assert_eq!(
                    other[4],
                    *hash,
                    "{name} ({}): the bits have changed: give {constant} another number, write the hashes down \
                     ({WISH}=write) and make the measured pages again (neural-mesh-bench measure)",
                    isa.name()
                ),
                None => new.push(row),
            }
        }
        if std::env::var(WISH).is_ok_and(|wish| wish == "write") {
            write(part, *version, new);
        } else {
            let names: Vec<&str> = new.iter().map(|row| row[3].as_str()).collect();
            assert!(
                new.is_empty(),
                "no golden hashes of version {version} of {part}: {names:?}: {WISH}=write adds them"
            );
        }
    }

    fn path() -> PathBuf {
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/bits.csv")
    }

    /// Rows of part, version, instructions, result, hash.
    fn read() -> Vec<[String; 5]> {
        let text = std::fs::read_to_string(path()).unwrap_or_default();
        let row = |line: &str| line.split(',').map(String::from).collect::<Vec<_>>().try_into().unwrap();
        text.lines().skip(1).map(row).collect()
    }

    /// The file with new rows, without those of other versions of the part.
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

    /// A hash of bits (FNV-1a).
    #[derive(Clone, Copy)]
    pub(crate) struct Hash(u64);

    impl Hash {
        pub(crate) fn new() -> Self {
            Self(0xcbf2_9ce4_8422_2325)
        }

        pub(crate) fn bytes(self, bytes: &[u8]) -> Self {
            Self(bytes.iter().fold(self.0, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)))
        }

        pub(crate) fn floats(self, floats: &[f32]) -> Self {
            floats.iter().fold(self, |hash, float| hash.bytes(&float.to_bits().to_le_bytes()))
        }

        pub(crate) fn indices(self, indices: &[u32]) -> Self {
            indices.iter().fold(self, |hash, index| hash.bytes(&index.to_le_bytes()))
        }

        pub(crate) fn value(self) -> u64 {
            self.0
        }
    }
}
