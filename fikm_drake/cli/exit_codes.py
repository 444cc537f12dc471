"""Exit codes of the command."""

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
EXIT_CODES = """exit codes:
  0    done
  1    the run failed, or a file could not be written
  2    bad arguments, or a model or scenario that is missing or not valid
  130  interrupted; the log so far is written where one was asked for"""
