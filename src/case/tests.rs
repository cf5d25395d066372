//! Tests of whole cases.
