//! `#[derive(Schema)]`: makes the struct that reads a table the one declaration of its keys.
//!
//! The macro implements `scenario::schema::Schema` for a type that derives serde's `Deserialize`. A key's name and
//! default come from the attributes that serde obeys. Its meaning comes from the doc comment, and its range from the
//! field's type. So a key is written once, and the reader, the JSON Schema and the reference agree.
//!
//! ```ignore
//! /// What the ego may do.
//! #[derive(Serialize, Deserialize, Schema)]
//! #[serde(deny_unknown_fields, default)]
//! pub struct Limits {
//!     /// Largest deceleration, m/s².
//!     pub deceleration_mps2: AccelerationMagnitude,
//! }
//! ```
//!
//! The derive supports structs and externally tagged enums. It supports serde's attributes `default`, `rename`,
//! `rename_all` of variants (`kebab-case`, `snake_case`), `expecting`, `skip` and `skip_deserializing`.

mod serde;
mod tables;

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Error, Expr, ExprLit, Field, Fields, Lit, Meta};

use crate::serde::Serde;

/// Implements `scenario::schema::Schema`: see the crate's documentation.
#[proc_macro_derive(Schema, attributes(serde))]
pub fn derive_schema(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let input = syn::parse_macro_input!(input as DeriveInput);
    expand(&input).unwrap_or_else(Error::into_compile_error).into()
}

/// Declares tables and words of a scenario file: `key: type` must be written, `key: type = default` may be left out.
///
/// A default is a number or a text of the key's type, a variant of it, `default` for the type's own, or an expression.
/// `sparse` is the type's own, and not written. A key of type `Option` may always be left out.
#[proc_macro]
pub fn tables(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    syn::parse_macro_input!(input as tables::Tables).0.into()
}

fn expand(input: &DeriveInput) -> Result<TokenStream, Error> {
    let name = &input.ident;
    let container = Serde::of(&input.attrs)?;
    let shape = match &input.data {
        Data::Struct(data) => shape_of(&container, &data.fields)?,
        Data::Enum(data) => {
            let variants = data.variants.iter().map(|variant| {
                let own = Serde::of(&variant.attrs)?;
                let spelled = || container.spelled(&variant.ident.to_string());
                let (name, meaning) = (own.rename.unwrap_or_else(spelled), meaning(&variant.attrs));
                let shape = match &variant.fields {
                    Fields::Unit => quote!(::core::option::Option::None),
                    fields => {
                        let shape = shape_of(&Serde::default(), fields)?;
                        quote!(::core::option::Option::Some(#shape))
                    }
                };
                Ok(quote!(::scenario::schema::Variant {
                    name: #name.to_owned(),
                    meaning: #meaning.to_owned(),
                    shape: #shape,
                }))
            });
            let variants = variants.collect::<Result<Vec<_>, Error>>()?;
            quote!(::scenario::schema::Shape::Choice(::std::vec![#(#variants),*]))
        }
        Data::Union(_) => return Err(Error::new_spanned(name, "a union has no keys")),
    };
    Ok(quote! {
        impl ::scenario::schema::Schema for #name {
            fn shape() -> ::scenario::schema::Shape {
                #shape
            }
        }
    })
}

/// The shape of the value that is read into `fields`.
fn shape_of(container: &Serde, fields: &Fields) -> Result<TokenStream, Error> {
    if let Fields::Named(named) = fields {
        let keys = named.named.iter().map(|field| key(container, field));
        let keys = keys.collect::<Result<Vec<_>, Error>>()?.into_iter().flatten();
        let defaults = container.default.as_ref().map(|_| {
            let all = quote!(&<Self as ::core::default::Default>::default());
            quote!(let defaults = ::scenario::schema::written(#all);)
        });
        return Ok(quote!({
            #defaults
            ::scenario::schema::Shape::Table(::std::vec![#(#keys),*])
        }));
    }
    let shape = |field: &Field| {
        let of = &field.ty;
        quote!(<#of as ::scenario::schema::Schema>::shape())
    };
    let shapes: Vec<_> = fields.iter().map(shape).collect();
    Ok(match shapes.as_slice() {
        [only] => only.clone(),
        all => {
            let usual = || format!("a list of {} values", all.len());
            let words = container.expecting.clone().unwrap_or_else(usual);
            quote!(::scenario::schema::Shape::Tuple(::std::vec![#(#all),*], #words))
        }
    })
}

/// The key of a field; none for a field that is not read.
fn key(container: &Serde, field: &Field) -> Result<Option<TokenStream>, Error> {
    let own = Serde::of(&field.attrs)?;
    if own.skip {
        return Ok(None);
    }
    let ident = || field.ident.as_ref().map(ToString::to_string).unwrap_or_default();
    let name = own.rename.unwrap_or_else(ident);
    let meaning = meaning(&field.attrs);
    let ty = &field.ty;
    let written = |value: TokenStream| quote!(Some(::scenario::schema::written(&#value)));
    let default = match (&own.default, &container.default) {
        (Some(None), _) => written(quote!(<#ty as ::core::default::Default>::default())),
        (Some(Some(path)), _) => written(quote!(#path())),
        (None, Some(_)) => quote!(Some(defaults.as_ref().and_then(|all| all.get(#name)).cloned())),
        (None, None) => quote!(None),
    };
    Ok(Some(quote!(::scenario::schema::Key::of::<#ty>(#name, #meaning, #default))))
}

/// The doc comment, in one line.
fn meaning(attributes: &[syn::Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => text(&pair.value),
        _ => None,
    });
    lines.map(|line| line.trim().to_owned()).collect::<Vec<_>>().join(" ").trim().to_owned()
}

fn text(value: &Expr) -> Option<String> {
    match value {
        Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value()),
        Expr::Group(group) => text(&group.expr),
        _ => None,
    }
}
