# cmake -DSOURCE=<tree> -DHEADER=<file> -P commit.cmake
#
# Writes ISPH_COMMIT, the git commit of a source tree, into a header: its first twelve digits, with
# "-dirty" where tracked files have changed; empty where the tree is no git repository of its own.
# The header is left alone where it would not change, so that nothing is compiled anew.

set(commit "")
find_program(GIT git)
if(GIT AND EXISTS ${SOURCE}/.git)
  execute_process(COMMAND ${GIT} -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
                  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()

set(text "#define ISPH_COMMIT \"${commit}\"\n")
set(before "")
if(EXISTS ${HEADER})
  file(READ ${HEADER} before)
endif()
if(NOT text STREQUAL before)
  file(WRITE ${HEADER} "${text}")
endif()
