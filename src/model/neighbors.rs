//! Cell grid.
