//! Laws side by side on the same scenarios ([`compare`]), and a figure as a function of any key ([`sweep`]).

pub mod compare;
pub mod sweep;
