"""Rules of collections, as pure functions: who gets which task, which texts are kept, what is paid."""
