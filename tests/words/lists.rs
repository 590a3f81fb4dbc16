//! Lists of words for the rules of `words.rs`, separated by blanks.

// Type names that may occur twice in a crate, each with the reason.
pub const SAME_NAMES: &[(&str, &str)] = &[];

// Irregular past forms.
pub const PAST_FORMS: &str = "\
    begun bent born bought broken brought built caught chosen dealt done drawn fallen felt fled flown foretold found \
    frozen given gone grown heard held hidden kept known laid led left lost made meant met paid risen said seen sent \
    shaken shown shrunk sold sought spent spoken spun stood struck stuck sunk swept swung taken thought thrown told \
    torn undone unwritten won worn wound woven written";

// Words in `ed` that are no past forms.
pub const ED_VERBS: &str = "\
    bed bleed breed embed exceed feed heed need proceed red reed seed shed speed succeed wed weed";

pub const PREPOSITIONS: &str = "\
    about above across after against along alongside amid among around as at before behind below beneath beside \
    besides between beyond by down during from in inside into near of off on onto out outside over per since than \
    through throughout to toward towards under until up upon via with within without";

pub const ADVERBS: &str = "\
    again also anew apart aside away both each else here how instead nothing only others ours rather same so \
    something still such theirs then there thus together what whatever where wherever whether which why yet";

// First words after which a past form is allowed, as in `is_kept`.
pub const PREFIXES: &str = "\
    as can from has into is may needs to try with";

// Words in `s` that are no verbs.
pub const NOUNS: &str = "\
    access across address afterwards always analysis areas arguments as atlas attributes axes axis barycenters basis \
    besides bias bodies boundaries boxes buckets buffers bus bytes candidates canvas cases channels charts checksums \
    circles class colours columns components coordinates cores corners creases cubes curves derivatives diagnostics \
    diagonals differences digits directions distances does edges eigenpairs entities entries epochs errors factors \
    fans figures files fractions gas genus gradients groups has heights his hours images indices instances is its \
    joints layers lengths less letters levels lines loops loss mass materials matrices means medians members minus \
    minutes neighbors neighbours nodes normals objects offsets ones options others pairs panels parameters parts \
    percents perhaps pieces pixels planes plus positions probabilities process proposals quadrics quarters radius \
    regions results rings roots rows scenes seams seconds seeds segments settings sides slots sources spheres spokes \
    spots statistics status success tables tangents targets tensors terms texels textures thirds this thus tools \
    tori triangles triples twins unless us values various vertices voices voxels was wedges weights whereas whose \
    words yes";

// Words in `s` that are nouns before one of [`AFTER_NOUNS`], and verbs elsewhere.
pub const NOUNS_OR_VERBS: &str = "\
    bends blocks bounds changes clusters collapses colors copies costs counts covers cuts ends estimates faces flips \
    halves indexes joins labels limits lists marks merges meshes moves names notes numbers orders packs patches \
    places points prices projects ranges ranks records reports samples scales scores shapes shares sizes splits \
    steps stores sums tests traces turns views walks weighs";

pub const AFTER_NOUNS: &str = "\
    and are around as at between by for from in of on or per that to were where which whose with within";

// Verbs with which no function doc should begin.
pub const WEAK_VERBS: &str = "\
    does has hears is";

// Words with which docs of types, fields and constants do not begin.
pub const NO_FIRST_WORDS: &str = "as how of so that those what whatever where which whoever why";

// Phrases to avoid, with their replacements.
pub const PHRASES: &[(&str, &str)] = &[
    ("so many", "the number"),
    ("anew", "again"),
    ("is asked of", "is required"),
    ("as far as", "where, if, up to"),
    ("told", "given, reported, passed"),
    ("heard", "received"),
    ("hear", "receive"),
    ("hears", "receives"),
    ("goes along", "is passed"),
    ("go along", "are passed"),
    ("stands", "is"),
    ("stand", "are"),
    ("stood", "was"),
    ("beside", "next to, in addition to, with"),
    ("what it is", "the thing itself"),
    ("what it was", "the thing itself"),
    ("what there is", "the thing itself"),
    ("what is there", "the thing itself"),
    ("what was there", "the thing itself"),
    ("what is asked", "the thing itself"),
    ("what was asked", "the thing itself"),
    ("what is given", "the thing itself"),
    ("what was given", "the thing itself"),
    ("what stays", "the thing itself"),
    ("what goes", "the thing itself"),
    ("what is left", "the thing itself"),
    ("what was left", "the thing itself"),
    ("in vain", "without success"),
    ("nobody", "who"),
    ("dressed", "with attributes"),
    ("becomes of", "happens to"),
    ("for want of", "without"),
    ("theirs", "whose"),
    ("hence", "so"),
    ("thereby", "so"),
    ("whereof", "two sentences"),
    ("thereof", "two sentences"),
    ("wherein", "two sentences"),
    ("therein", "two sentences"),
    ("thereupon", "two sentences"),
    ("whereby", "two sentences"),
    ("of all of them", "of all"),
    ("of all of it", "of all"),
    ("does something", "runs"),
    ("seen through", "opaque"),
    ("has no figure", "is empty"),
    ("than they show", "better spent elsewhere"),
    ("how many times farther", "the largest growth"),
    ("as large as the mesh is", "the input size"),
];
