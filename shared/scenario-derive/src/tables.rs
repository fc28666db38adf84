//! `tables!`: tables and words of a scenario file, each key in one row with its default.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Attribute, Error, Expr, Fields, Ident, ItemEnum, Lit, Token, Type, Visibility, braced};

use crate::serde::{Serde, is_serde};

/// The declarations of one call.
pub(crate) struct Tables(pub TokenStream);

/// A table before its keys are read.
struct Table {
    attributes: Vec<Attribute>,
    visibility: Visibility,
    name: Ident,
    keys: Punctuated<Key, Token![,]>,
}

/// `key: type` of a key that must be written, `key: type = default` of all others.
struct Key {
    attributes: Vec<Attribute>,
    visibility: Visibility,
    name: Ident,
    of: Type,
    default: Option<Expr>,
}

impl Parse for Tables {
    fn parse(input: ParseStream<'_>) -> Result<Self, Error> {
        let mut items = TokenStream::new();
        while !input.is_empty() {
            let ahead = input.fork();
            ahead.call(Attribute::parse_outer)?;
            ahead.parse::<Visibility>()?;
            items.extend(match ahead.peek(Token![enum]) {
                true => words(&input.parse()?)?,
                false => input.parse::<Table>()?.declared(),
            });
        }
        Ok(Self(items))
    }
}

impl Parse for Table {
    fn parse(input: ParseStream<'_>) -> Result<Self, Error> {
        let attributes = input.call(Attribute::parse_outer)?;
        let visibility = input.parse()?;
        input.parse::<Token![struct]>()?;
        let name = input.parse()?;
        let body;
        braced!(body in input);
        let keys = body.parse_terminated(Key::parse, Token![,])?;
        Ok(Self { attributes, visibility, name, keys })
    }
}

impl Parse for Key {
    fn parse(input: ParseStream<'_>) -> Result<Self, Error> {
        let attributes = input.call(Attribute::parse_outer)?;
        let (visibility, name) = (input.parse()?, input.parse()?);
        input.parse::<Token![:]>()?;
        let of = input.parse()?;
        let default = input.parse::<Option<Token![=]>>()?.map(|_| input.parse()).transpose()?;
        Ok(Self { attributes, visibility, name, of, default })
    }
}

impl Key {
    /// The default: a number, a text or a constant is wrapped by the type, a word is a variant of it.
    fn default(&self) -> Option<TokenStream> {
        let of = &self.of;
        let Some(default) = &self.default else {
            return is_option(of).then(|| quote!(::core::option::Option::None));
        };
        Some(match default {
            Expr::Lit(literal) if matches!(literal.lit, Lit::Bool(_)) => quote!(#default),
            Expr::Lit(_) | Expr::Unary(_) => quote!(<#of>::of(#default)),
            Expr::Path(_) if is_word(default, "default") || is_word(default, "sparse") => {
                quote!(<#of as ::core::default::Default>::default())
            }
            Expr::Path(path) => match path.path.get_ident() {
                Some(name) if name.to_string().contains(char::is_lowercase) => {
                    quote!(<#of>::#name)
                }
                _ => quote!(<#of>::of(#default)),
            },
            other => quote!(#other),
        })
    }
}

impl Table {
    /// The struct with what reads, writes and describes it. A table without a required key has a `Default`.
    fn declared(&self) -> TokenStream {
        let Self { attributes, visibility, name, keys } = self;
        let is_optional = keys.iter().all(|key| key.default().is_some());
        let (mut fields, mut functions, mut values) = (Vec::new(), Vec::new(), Vec::new());
        for key in keys {
            let Key { attributes, visibility, name: field, of, .. } = key;
            let function = format_ident!("default_{field}");
            let fallback = key.default().filter(|_| !is_optional).map(|default| {
                functions.push(quote!(fn #function() -> #of { #default }));
                let path = format!("{name}::{function}");
                quote!(#[serde(default = #path)])
            });
            let default = key.default();
            values.push(quote!(#field: #default));
            let is_sparse = key.default.as_ref().is_some_and(|own| is_word(own, "sparse"));
            let sparse = (is_sparse || is_option(of))
                .then(|| quote!(#[serde(skip_serializing_if = "crate::schema::is_default")]));
            fields.push(quote!(#(#attributes)* #sparse #fallback #visibility #field: #of));
        }
        let container = is_optional.then(|| quote!(, default));
        let usual = is_optional.then(|| {
            quote! {
                impl ::core::default::Default for #name {
                    fn default() -> Self {
                        Self { #(#values),* }
                    }
                }
            }
        });
        quote! {
            #(#attributes)*
            #[derive(Clone, Debug, PartialEq, ::serde::Serialize, ::serde::Deserialize, ::scenario::schema::Schema)]
            #[serde(deny_unknown_fields #container)]
            #visibility struct #name { #(#fields),* }

            impl #name { #(#functions)* }
            #usual
        }
    }
}

/// An enum in kebab case, unless its own attribute says another. One of words alone is `Copy` and has their list.
fn words(item: &ItemEnum) -> Result<TokenStream, Error> {
    let spelling = (!item.attrs.iter().any(is_serde))
        .then(|| quote!(#[serde(rename_all = "kebab-case", deny_unknown_fields)]));
    let mut attributes = item.variants.iter().flat_map(|variant| &variant.attrs);
    let has_default = attributes.any(|attribute| attribute.path().is_ident("default"));
    let default = has_default.then(|| quote!(, ::core::default::Default));
    let is_words = item.variants.iter().all(|variant| matches!(variant.fields, Fields::Unit));
    let copy = is_words.then(|| quote!(, Copy, Eq));
    let list = if is_words { Some(list(item)?) } else { None };
    Ok(quote! {
        #[derive(Clone, Debug, PartialEq, ::serde::Serialize, ::serde::Deserialize, ::scenario::schema::Schema #copy #default)]
        #spelling
        #item
        #list
    })
}

/// The words of an enum that has no more.
fn list(item: &ItemEnum) -> Result<TokenStream, Error> {
    let mut own = Serde::of(&item.attrs)?;
    if !item.attrs.iter().any(is_serde) {
        own.separator = Some('-');
    }
    let (name, count) = (&item.ident, item.variants.len());
    let variants: Vec<_> = item.variants.iter().map(|variant| &variant.ident).collect();
    let names = item.variants.iter().map(|variant| {
        let renamed = Serde::of(&variant.attrs)?.rename;
        Ok(renamed.unwrap_or_else(|| own.spelled(&variant.ident.to_string())))
    });
    let names = names.collect::<Result<Vec<_>, Error>>()?;
    Ok(quote! {
        impl #name {
            /// All of them.
            pub const ALL: [Self; #count] = [#(Self::#variants),*];

            /// The name in files and in results.
            pub const fn name(self) -> &'static str {
                match self {
                    #(Self::#variants => #names),*
                }
            }
        }
    })
}

fn is_word(default: &Expr, word: &str) -> bool {
    matches!(default, Expr::Path(path) if path.path.is_ident(word))
}

fn is_option(of: &Type) -> bool {
    let Type::Path(path) = of else { return false };
    path.path.segments.last().is_some_and(|segment| segment.ident == "Option")
}
