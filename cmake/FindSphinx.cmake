# SPDX-License-Identifier: Apache-2.0
# Sphinx_FOUND, SPHINX_BUILD, SPHINX_PYTHON, Sphinx_VERSION. Components are Python modules that the Python of that
# sphinx-build has to have, e.g. find_package(Sphinx COMPONENTS breathe myst_parser).
find_program(SPHINX_BUILD sphinx-build DOC "Program that builds the documentation's pages")
mark_as_advanced(SPHINX_BUILD)
set(SPHINX_PYTHON "")
if(SPHINX_BUILD AND EXISTS "${SPHINX_BUILD}")
  # A script: its first line names the Python whose modules it will see.
  file(STRINGS "${SPHINX_BUILD}" sphinx_first_line LIMIT_COUNT 1)
  if(sphinx_first_line MATCHES "^#! *([^ ]+)")
    set(SPHINX_PYTHON "${CMAKE_MATCH_1}")
    execute_process(COMMAND "${SPHINX_PYTHON}" -c "import sphinx; print(sphinx.__version__)"
      OUTPUT_VARIABLE Sphinx_VERSION ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
    foreach(component IN LISTS Sphinx_FIND_COMPONENTS)
      execute_process(COMMAND "${SPHINX_PYTHON}" -c "import ${component}"
        RESULT_VARIABLE sphinx_result OUTPUT_QUIET ERROR_QUIET)
      if(sphinx_result EQUAL 0)
        set(Sphinx_${component}_FOUND TRUE)
      endif()
    endforeach()
  endif()
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Sphinx REQUIRED_VARS SPHINX_BUILD SPHINX_PYTHON
  VERSION_VAR Sphinx_VERSION HANDLE_COMPONENTS)
