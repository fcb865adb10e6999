# Sets manual_options, all options in roff, from the page docs/reference/options.md. A test,
# tests/commandline.py, keeps this page equal to the tables that isph parses.

set(page ${CMAKE_SOURCE_DIR}/docs/reference/options.md)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${page})
file(READ ${page} text)
string(FIND "${text}" "\n## " start)
string(SUBSTRING "${text}" ${start} -1 text)
string(FIND "${text}" "\n## Defaults by the regime" end)
string(SUBSTRING "${text}" 0 ${end} text)
string(APPEND text "\n## Defaults by the regime\n\nA table of them: isph -catalogue.\n")
string(REGEX REPLACE "\n\\| (option|---) [^\n]*" "" text "${text}") # heads of tables

# Markdown escapes a bar within a cell, among others; roff escapes dashes.
string(ASCII 1 bar)
string(REPLACE "\\|" "${bar}" text "${text}")
string(REGEX REPLACE "\\\\([<>*_])" "\\1" text "${text}")
string(REPLACE "-" "\\-" text "${text}")

# A row becomes a tagged paragraph: name and value; meaning, unit, default, allowed values, runs.
string(REGEX REPLACE " *\\| *" "|" text "${text}")
set(cell "\\|([^|\n]*)")
string(REGEX REPLACE "\n\\|`([^`]+)`${cell}${cell}${cell}${cell}${cell}${cell}\\|"
       "\n.TP\n.BI \"\\1\" \" \\2\"\n\\\\&\\7 [\\3]; default \\4; \\5; for \\6;" text "${text}")
foreach(empty IN ITEMS " \" \"" " []")
  string(REPLACE "${empty}" "" text "${text}")
endforeach()
foreach(empty IN ITEMS " default" " for" "")
  string(REPLACE ";${empty} ;" ";" text "${text}")
endforeach()
string(REPLACE ";\n" ".\n" text "${text}")

string(REGEX REPLACE "\n## ([^\n]*)\n" "\n.SS \\1" text "${text}")
string(REGEX REPLACE "\n+" "\n" text "${text}")
string(REPLACE "`" "" text "${text}")
string(REPLACE "${bar}" "|" text "${text}")
string(STRIP "${text}" manual_options)
