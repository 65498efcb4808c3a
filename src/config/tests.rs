//! The list of keys, the reader and the manual say the same.
