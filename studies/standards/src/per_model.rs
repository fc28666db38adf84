//! One value for each model.

use crate::Model;

/// One value for each model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerModel<T> {
    values: [T; 4],
}

impl<T> PerModel<T> {
    /// The values that `value` gives for each model.
    pub fn new(value: impl FnMut(Model) -> T) -> PerModel<T> {
        PerModel { values: Model::ALL.map(value) }
    }

    /// The models with their values, in the order of the tables.
    pub fn iter(&self) -> impl Iterator<Item = (Model, &T)> {
        Model::ALL.into_iter().zip(&self.values)
    }
}

impl<T> std::ops::Index<Model> for PerModel<T> {
    type Output = T;

    fn index(&self, model: Model) -> &T {
        &self.values[model as usize]
    }
}

impl<T> std::ops::IndexMut<Model> for PerModel<T> {
    fn index_mut(&mut self, model: Model) -> &mut T {
        &mut self.values[model as usize]
    }
}
