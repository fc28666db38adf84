//! The following figure.

use crate::error::Error;
use crate::reproduce::Runner;
use crate::reproduce::plot::Plots;
use crate::reproduce::row::Row;

pub fn reproduce(
    _runner: &mut Runner<'_>,
    _rows: &mut Vec<Row>,
    _plots: &mut Plots,
) -> Result<(), Error> {
    Ok(())
}
