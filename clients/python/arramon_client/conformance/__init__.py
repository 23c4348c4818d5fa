"""Conformance suite: checks that any server of the protocol, given by its address, keeps the protocol's contract.

`command` is the command line, `suite` runs checks, `checks` lists them; `target` is the server under test, `player` a
raw Play stream, `outcomes` a check's assertions. Every other module is one group of checks.
"""
