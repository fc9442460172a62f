//! Triangle surfaces, exact primitives on them, and the contact record that collision handling shares.
