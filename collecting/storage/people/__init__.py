"""Tables of the people: workers and hosts, sign-ins, visits from platforms, deletion."""
