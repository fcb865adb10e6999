/* Tables of named rows: search by name, choice by an option, and lists of words. No other file
   compares names of rows. */
#include "isph/base.h"
#include <stdio.h>
#include <string.h>

#define EXTENSIONS 64 /* most tables of plug-ins */

/* Rows of plug-ins, which all runs of the process have: as their code, they stay to its end. */
static struct {
  const Table *table, *rows;
} extension[EXTENSIONS];

/* TableExtend - Adds rows to a table, once; they must exist to the end of the process */
PetscErrorCode TableExtend(const Table *table, const Table *rows)
{
  PetscInt k = 0;

  PetscFunctionBegin;
  while (k < EXTENSIONS && extension[k].rows && extension[k].rows != rows) k++;
  PetscCheck(k < EXTENSIONS, PETSC_COMM_WORLD, PETSC_ERR_USER_INPUT,
             "-library: at most %d tables of rows are allowed", EXTENSIONS);
  extension[k].table = table;
  extension[k].rows  = rows;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TableCount - Returns the number of rows of a table, plug-ins included */
PetscInt TableCount(const Table *table)
{
  PetscInt n = table->count;

  for (PetscInt e = 0; e < EXTENSIONS && extension[e].rows; e++)
    if (extension[e].table == table) n += extension[e].rows->count;
  return n;
}

/* TableGet - Returns the name, the brief and the citation of row k, with which every row begins.
   Not collective. Input: k - at least 0, less than TableCount(). */
const TableRow *TableGet(const Table *table, PetscInt k)
{
  for (PetscInt e = 0; k >= table->count && e < EXTENSIONS; e++) {
    if (extension[e].table != table) continue;
    if (k - table->count < extension[e].rows->count)
      return TableGet(extension[e].rows, k - table->count);
    k -= extension[e].rows->count;
  }
  if (!table->row_size) return ((const TableRow *const *)table->rows)[k];
  return (const TableRow *)(const void *)((const char *)table->rows + (size_t)k * table->row_size);
}

/* TableFind - Finds the row with a given name; capitals and small letters are equal. Output: row -
   NULL if the table has no such name. */
PetscErrorCode TableFind(const Table *table, const char name[], const TableRow **row)
{
  PetscFunctionBegin;
  *row = NULL;
  for (PetscInt k = 0; k < TableCount(table); k++) {
    PetscBool same;

    PetscCall(PetscStrcasecmp(TableGet(table, k)->name, name, &same));
    if (same) *row = TableGet(table, k);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TextAppend - Appends to a text as far as there is room in its `size` characters. PETSc 3.18's own
   function counts the room from the beginning of the text, and writes beyond its end. */
void TextAppend(char text[], size_t size, const char more[])
{
  const size_t length = strlen(text);

  if (length + 1 < size) (void)snprintf(text + length, size - length, "%s", more);
}

/* AppendWord - Appends a word to a list, "a, b, c", as far as there is room */
void AppendWord(char list[], size_t size, const char word[])
{
  if (list[0]) TextAppend(list, size, ", ");
  TextAppend(list, size, word);
}

/* TableWant - Finds the row with a given name, which must exist. Input: option - the option that
   gave the name, for messages. Output: row - address of a pointer to the row, which may have any
   row type. */
PetscErrorCode TableWant(const Table *table, const char option[], const char name[], void *row)
{
  char            names[1024] = "";
  const TableRow *found;

  PetscFunctionBegin;
  PetscCall(TableFind(table, name, &found));
  for (PetscInt k = 0; k < TableCount(table); k++)
    AppendWord(names, sizeof(names), TableGet(table, k)->name);
  UserCheck(name[0], "%s: a name is required; choose one of %s", option, names);
  UserCheck(found, "%s %s: no such name; choose one of %s", option, name, names);
  *(const TableRow **)row = found;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TableView - Lists a table for -catalogue: names, briefs, publications and declared properties.
   Collective on the viewer. */
PetscErrorCode TableView(const Table *table, const char options[], PetscViewer viewer)
{
  PetscFunctionBegin;
  PetscCall(PetscViewerASCIIPrintf(viewer, "\n%s (%s)\n", table->title, options));
  for (PetscInt k = 0; k < TableCount(table); k++) {
    const TableRow *row = TableGet(table, k);

    PetscCall(PetscViewerASCIIPrintf(viewer, "  %-16s %s\n", row->name, row->brief));
    if (row->citation)
      PetscCall(PetscViewerASCIIPrintf(viewer, "  %-16s [%s]\n", "", row->citation));
    if (table->Describe) {
      char text[256] = "";

      PetscCall(table->Describe(row, text, sizeof(text)));
      PetscCall(PetscViewerASCIIPrintf(viewer, "  %-16s %s\n", "", text));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TableViewRow - Prints a chosen row as a line of the banner: label, name, brief and citation.
   Collective on the viewer. The brief is omitted if the line would exceed 100 columns and the row
   has a citation. If row is NULL, nothing is printed. */
PetscErrorCode TableViewRow(const char label[], const void *row, PetscViewer viewer)
{
  const TableRow *r = row;
  char            line[512];
  size_t          length;

  PetscFunctionBegin;
  if (!r) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(line, sizeof(line), "%-11s %s: %s%s%s%s", label, r->name, r->brief,
                          r->citation ? " [" : "", r->citation ? r->citation : "",
                          r->citation ? "]" : ""));
  PetscCall(PetscStrlen(line, &length));
  if (length > 100 && r->citation)
    PetscCall(PetscSNPrintf(line, sizeof(line), "%-11s %s [%s]", label, r->name, r->citation));
  PetscCall(PetscViewerASCIIPrintf(viewer, "%s\n", line));
  PetscFunctionReturn(PETSC_SUCCESS);
}
