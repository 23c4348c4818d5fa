"""Conformance suite: checks that any server of the protocol, given by its address, keeps the protocol's contract.

`command` is the command line, `suite` runs checks, `checks` lists them; `target` is the server under test, `raw_stream`
a Play stream, `assertions` the functions that raise violations. Every other module is one group of checks.
"""
