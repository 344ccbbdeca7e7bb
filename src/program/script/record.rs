//! Options as data: a record is a list of rows, and everything that is said of an option comes from
//! its row.
//!
//! ```text
//! options! { struct ViewOptions { /// to the right
//!                                 azimuth: f64 = Number(AZIMUTH).or(0.0), … } }
//!      │
//!      ├─ ViewOptions::read(object, table)   known keys, types, ranges, messages → plain fields
//!      └─ ViewOptions::rows()                annotations::class → scripts/library/lampyris.lua
//!                                            annotations::table → the option tables in docs/
//! ```
//!
//! To add an option, write its row (a sentence, `key: type = kind`) and use the field: the compiler
//! warns of a row without a use, `MAKE_REF=1 cargo test --lib annotations` writes the annotations
//! and the manual's tables anew. A new record is also named in `annotations::RECORDS`.

use mlua::Value;

use super::kinds::Kind;
use super::options::Options;

/// What is said of one option.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct OptionRow {
    pub key: &'static str,
    /// For the Lua language server.
    pub lua_type: String,
    pub is_required: bool,
    /// Which values are allowed, with their unit; empty if the type says it.
    pub allowed: String,
    /// What stands where a script gives none, as it would write it or in words; may be empty.
    pub default: String,
    /// Without a full stop; may be empty where the key says it.
    pub sentence: String,
}

impl OptionRow {
    pub(super) fn new<T, K: Kind<Read = T>>(key: &'static str, kind: &K, sentence: &str) -> Self {
        Self {
            key,
            lua_type: kind.lua_type(),
            is_required: kind.is_required(),
            allowed: kind.allowed(),
            default: kind.default_text(),
            sentence: sentence.trim().to_owned(),
        }
    }
}

/// A table of named options, as a struct of what they mean.
pub(super) trait Record: Sized {
    /// Name of the record in the annotations.
    const CLASS: &'static str;

    fn rows() -> Vec<OptionRow>;

    fn keys() -> Vec<&'static str>;

    /// The fields, read from a table whose keys are known.
    fn from_options(options: &Options) -> mlua::Result<Self>;

    /// Errors: not a table (nil stands for an empty one), unknown keys, and what each row refuses.
    fn read(object: &str, value: Value) -> mlua::Result<Self> {
        Self::from_options(&Options::new(object, value, &Self::keys())?)
    }
}

/// Declares a [`Record`]: documented rows `key: type = kind`, then records whose rows it shares
/// as `..field: Type`.
macro_rules! options {
    (
        $(#[$about:meta])*
        struct $record:ident {
            $($(#[doc = $sentence:literal])* $key:ident: $type:ty = $kind:expr,)*
            $(..$shared:ident: $shared_type:ty,)*
        }
    ) => {
        $(#[$about])*
        pub(super) struct $record {
            $($(#[doc = $sentence])* pub(super) $key: $type,)*
            $(pub(super) $shared: $shared_type,)*
        }

        impl $crate::program::script::record::Record for $record {
            const CLASS: &'static str = stringify!($record);

            fn rows() -> Vec<$crate::program::script::record::OptionRow> {
                #[allow(unused_mut)]
                let mut rows = vec![$($crate::program::script::record::OptionRow::new::<$type, _>(
                    stringify!($key), &$kind, concat!("", $($sentence),*)
                )),*];
                $(rows.extend(<$shared_type>::rows());)*
                rows
            }

            fn keys() -> Vec<&'static str> {
                #[allow(unused_mut)]
                let mut keys = vec![$(stringify!($key)),*];
                $(keys.extend(<$shared_type>::keys());)*
                keys
            }

            fn from_options(
                options: &$crate::program::script::options::Options,
            ) -> mlua::Result<Self> {
                Ok(Self {
                    $($key: options.read(stringify!($key), &$kind)?,)*
                    $($shared: <$shared_type>::from_options(options)?,)*
                })
            }
        }
    };
}

pub(super) use options;
