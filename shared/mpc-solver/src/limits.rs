//! Upper limits on a problem's size, and the faults of a problem.

/// Largest horizon \[steps\].
pub const MAX_HORIZON: usize = 1000;
/// Largest number of rows of a problem.
pub const MAX_ROWS: usize = 4;

/// Reason why a problem cannot be built or solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProblemError {
    /// The horizon is zero or above [`MAX_HORIZON`].
    #[error("the horizon is {0} steps; it must be 1 to {MAX_HORIZON}")]
    Horizon(usize),
    /// A number is NaN or infinite; the text names it.
    #[error("a number is not finite: {0}")]
    NotFinite(&'static str),
    /// `A` has an entry below its diagonal.
    #[error("the dynamics matrix has an entry below its diagonal")]
    NotUpperTriangular,
    /// `B` is zero: the input would have no effect.
    #[error("the input has no effect on the state")]
    NoInput,
    /// `u_min` is not below `u_max`.
    #[error("the lower input bound is not below the upper one")]
    EmptyInputRange,
    /// `r` is not positive.
    #[error("the cost of the input must be positive")]
    InputCost,
    /// A cost matrix is not symmetric; the text names it.
    #[error("the {0} is not symmetric")]
    NotSymmetric(&'static str),
    /// A cost matrix is not positive semidefinite; the text names it.
    #[error("the {0} is not positive semidefinite")]
    NotConvex(&'static str),
    /// There are more than [`MAX_ROWS`] rows.
    #[error("there are {0} rows; at most {MAX_ROWS} are possible")]
    TooManyRows(usize),
    /// A row names stages outside of `1..=N`; the number is the row's index.
    #[error("row {0} names stages outside of the horizon")]
    RowStages(usize),
    /// A row's gradient is zero; the number is the row's index.
    #[error("row {0} has a zero gradient")]
    EmptyRow(usize),
    /// A soft limit's linear penalty weight is not positive, or its quadratic one is negative.
    #[error("a soft limit needs a positive linear and a non-negative quadratic penalty weight")]
    PenaltyWeight,
    /// The light's weight or threshold is not positive.
    #[error("the light's weight and threshold must be positive")]
    Light,
}
