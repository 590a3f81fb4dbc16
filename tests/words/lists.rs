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

// Names that no closure has.
pub const NO_CLOSURE_NAMES: &str = "at by it of";

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
