//! Two bodies in contact, solved and certified by one library call
