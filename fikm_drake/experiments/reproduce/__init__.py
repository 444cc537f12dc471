"""What `fikm-drake reproduce` runs: one folder a paper, one function a table, figure or claim.

Each returns a `Section` (`report`): the paper's value beside ours, and whether the claim is reached.
`papers` names them.
"""
