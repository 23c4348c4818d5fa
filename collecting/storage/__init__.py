"""Storage of collections: one module for each group of tables; all access to them is here."""
