/* Texts about options: usage, -help and the reference page. All but the usage come from the tables
   of options. The versions of the program and of libraries that may influence its numbers. */
#include "commit.h"
#include "isph/options.h"
#include <hdf5.h>
#include <petscpkg_version.h>
#include <string.h>

#define TEXT_LENGTH 1600 /* of the text about an option */
#define LINE_WIDTH  100
#define INDENT      34 /* of the text about an option in -help */

static const char *const kinds[] = {
    [VALUE_SWITCH]     = "true|false",
    [VALUE_INT]        = "int",
    [VALUE_REAL]       = "real",
    [VALUE_REALS]      = "real,...",
    [VALUE_NAME]       = "name",
    [VALUE_NAMES]      = "name,...",
    [VALUE_FILE]       = "file",
    [VALUE_EXPRESSION] = "expression,...",
    [VALUE_SHAPE]      = "shape,real,...",
    [VALUE_VIEWER]     = "viewer",
    [VALUE_WORD]       = "word",
    [VALUE_NOTHING]    = "",
    [VALUE_MONITOR]    = "value",
    [VALUE_SOLVER]     = "value",
};

/* The options that most runs need, in the order of -help. */
static const char *const common[] = {
    "-case",   "-reynolds",     "-viscosity",  "-length",  "-speed",  "-n",
    "-t_end",  "-dt",           "-motion",     "-scheme",  "-output", "-output_every",
    "-report", "-probe_forces", "-checkpoint", "-restart",
};

/* Appends a part with the words before and after it to a text; nothing if the part is empty. */
static void Append(char text[TEXT_LENGTH], const char before[], const char part[],
                   const char after[])
{
  if (!part || !part[0]) return;
  TextAppend(text, TEXT_LENGTH, before);
  TextAppend(text, TEXT_LENGTH, part);
  TextAppend(text, TEXT_LENGTH, after);
}

/* Writes the allowed values of an option: a range, or names separated by commas. */
static void Allowed(const OptionRow *row, char text[TEXT_LENGTH])
{
  char names[TEXT_LENGTH] = "";

  OptionRangeText(row, text, TEXT_LENGTH);
  for (PetscInt k = 0; row->kind == VALUE_NAME && k < TableCount(row->table); k++)
    AppendWord(names, sizeof(names), TableGet(row->table, k)->name);
  for (PetscInt k = 0; row->words && row->words[k]; k++)
    AppendWord(names, sizeof(names), row->words[k]);
  Append(text, row->kind == VALUE_NAMES ? "some of " : "one of ", names, "");
}

/* Prints a text from column INDENT on, in lines of LINE_WIDTH columns. Input: column - number of
   letters already in the line. */
static void PrintWrapped(FILE *out, int column, const char text[])
{
  if (column < INDENT - 1) (void)fprintf(out, "%*s", INDENT - column, "");
  else (void)fprintf(out, "\n%*s", INDENT, "");
  column = INDENT;
  while (*text) {
    const int word = (int)strcspn(text, " ");

    if (column > INDENT && column + 1 + word > LINE_WIDTH) {
      (void)fprintf(out, "\n%*s", INDENT, "");
      column = INDENT;
    } else if (column > INDENT) {
      (void)fputc(' ', out);
      column++;
    }
    (void)fprintf(out, "%.*s", word, text);
    column += word;
    text += word;
    text += strspn(text, " ");
  }
  (void)fputc('\n', out);
}

static void PrintOption(FILE *out, const OptionRow *row)
{
  char      text[TEXT_LENGTH] = "", part[TEXT_LENGTH];
  const int column =
      fprintf(out, kinds[row->kind][0] ? "  %s <%s>" : "  %s", row->name, kinds[row->kind]);

  Append(text, "", row->brief, "");
  Append(text, " [", row->unit, "]");
  Append(text, "; default ", row->standard, "");
  Allowed(row, part);
  Append(text, "; ", part, "");
  Append(text, "; for ", row->where, "");
  PrintWrapped(out, column, text);
}

/* Returns true if an earlier row of the table has the words of a row. */
static PetscBool HasPlacesBefore(const OptionTable *table, const OptionRow *row)
{
  const OptionRow *earlier;

  for (PetscInt k = 0; (earlier = OptionNext(table, &k)) && earlier != row;)
    if (earlier->places == row->places) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Prints the words that stand in place of <word> in names of options, each list once. */
static void PrintPlaces(FILE *out, const OptionTable *table, PetscBool markdown)
{
  const OptionRow *row;

  for (PetscInt k = 0; (row = OptionNext(table, &k));) {
    const char *open             = strchr(row->name, '<');
    char        all[TEXT_LENGTH] = "";
    int         length;

    if (!row->places || HasPlacesBefore(table, row)) continue;
    length = (int)strcspn(open, ">") + 1;
    for (PetscInt q = 0; row->places[q]; q++) AppendWord(all, sizeof(all), row->places[q]);
    if (markdown) {
      (void)fprintf(out, "\n`%.*s` stands for %s.\n", length, open, all);
    } else {
      PrintWrapped(out, fprintf(out, "  %.*s stands for", length, open), all);
    }
  }
}

/* UsagePrint - Prints how to begin, for a command line without options */
void UsagePrint(FILE *out)
{
  (void)fputs(
      "isph: incompressible viscous flow by Smoothed Particle Hydrodynamics on PETSc\n"
      "\n"
      "usage: isph -option value ...         or: mpiexec -n 4 isph -option value ...\n"
      "\n"
      "  isph -case cavity -n 32 -t_end 5 -output flow.h5      a flow, and files for ParaView\n"
      "  isph -options_file options/cavity.opts -reynolds 400  options of a file, then others\n"
      "  isph -case cavity -reynolds 0.01 -motion eulerian -scheme coupled -steady\n"
      "  isph -case scene -scene_body_1 circle,0.5,0.5,0.2 -scene_wall_top_velocity 1,0 -n 40\n"
      "\n"
      "  -help             the options that most runs need, then all options of isph; -help WORD\n"
      "                    searches them, -help petsc adds PETSc's for the chosen solvers\n"
      "  -catalogue        cases, operators, walls, schemes and integrators with their papers\n"
      "  -version          versions of isph and of the libraries it stands on\n",
      out);
}

/* Returns true if a table has options for all users. */
static PetscBool IsForAll(const OptionTable *table)
{
  const OptionRow *row;

  for (PetscInt k = 0; (row = OptionNext(table, &k));)
    if (!row->expert) return PETSC_TRUE;
  return PETSC_FALSE;
}

#define EXPERT "Expert: for studies of the numerics"

/* HelpSearch - Prints the options that have a word as another name, then those that have it in
   their name or meaning. Needs neither PETSc nor MPI to be initialized. Prints that there is none.
 */
void HelpSearch(FILE *out, const char word[])
{
  PetscInt found = 0;
  char     name[OPTION_LENGTH];

  (void)snprintf(name, sizeof(name), " %s ", word);
  for (PetscInt also = 1; also >= 0; also--) {
    for (PetscInt t = 0; OptionTableGet(t); t++) {
      const OptionRow *row;

      for (PetscInt k = 0; (row = OptionNext(OptionTableGet(t), &k));) {
        const PetscBool is = OptionTextHas(row->also, name);

        if (also ? !is
                 : is || !(OptionTextHas(row->name, word) || OptionTextHas(row->brief, word) ||
                           OptionTextHas(row->also, word)))
          continue;
        PrintOption(out, row);
        found++;
      }
    }
  }
  if (!found)
    (void)fprintf(out, "no option has \"%s\" in its name or meaning; -help lists all\n", word);
}

/* HelpPrint - Prints the options that most runs need, then all options of isph, in groups. Needs
   neither PETSc nor MPI to be initialized. */
void HelpPrint(FILE *out)
{
  UsagePrint(out);
  (void)fprintf(out, "\nThe options that most runs need:\n\n");
  for (size_t k = 0; k < sizeof(common) / sizeof(common[0]); k++)
    PrintOption(out, OptionFind(common[k]));
  (void)fprintf(out, "\n%s\n",
                "All options, with unit, default (by the regime: in -catalogue), allowed values, "
                "and their runs:");
  for (PetscInt t = 0; OptionTableGet(t); t++) {
    const OptionTable *table = OptionTableGet(t);
    const OptionRow   *row;

    if (!IsForAll(table)) continue;
    (void)fprintf(out, "\n%s\n", table->title);
    PrintPlaces(out, table, PETSC_FALSE);
    for (PetscInt k = 0; (row = OptionNext(table, &k));)
      if (!row->expert) PrintOption(out, row);
  }
  (void)fprintf(out, "\n%s\n", EXPERT);
  for (PetscInt t = 0; OptionTableGet(t); t++) {
    const OptionRow *row;

    for (PetscInt k = 0; (row = OptionNext(OptionTableGet(t), &k));)
      if (row->expert) PrintOption(out, row);
  }
}

/* Prints a cell of a table in Markdown; NULL is empty. */
static void PrintCell(FILE *out, const char text[])
{
  (void)fputs(" ", out);
  for (const char *c = text ? text : ""; *c; c++) {
    if (strchr("|<>*_", *c)) (void)fputc('\\', out);
    (void)fputc(*c, out);
  }
  (void)fputs(text && *text ? " |" : "|", out);
}

/* Prints the head of a table of options in Markdown. */
static void PrintHead(FILE *out)
{
  (void)fputs("\n| option | value | unit | default | allowed | used by | meaning |\n"
              "| --- | --- | --- | --- | --- | --- | --- |\n",
              out);
}

/* Prints the options of a table in Markdown: those for experts, or the others. */
static void PrintRows(FILE *out, const OptionTable *table, PetscBool expert)
{
  const OptionRow *row;

  for (PetscInt k = 0; (row = OptionNext(table, &k));) {
    char allowed[TEXT_LENGTH];

    if (row->expert != expert) continue;
    Allowed(row, allowed);
    (void)fprintf(out, "| `%s` |", row->name);
    PrintCell(out, kinds[row->kind]);
    PrintCell(out, row->unit);
    PrintCell(out, row->standard);
    PrintCell(out, allowed);
    PrintCell(out, row->where);
    PrintCell(out, row->brief);
    (void)fputc('\n', out);
  }
}

/* ReferencePrint - Prints the reference page of all options, in Markdown. Needs neither PETSc nor
   MPI to be initialized. */
void ReferencePrint(FILE *out)
{
  (void)fputs(
      "# Options\n"
      "\n"
      "Written by `isph -options_reference` from the tables that the program parses. An option is\n"
      "typed as `-name value`, on the command line or in a file, where each has a line of its own\n"
      "(`-options_file`). Before these, options of `~/.petscrc`, `.petscrc`, `petscrc` and of the\n"
      "environment variable `PETSC_OPTIONS` are read. Names have no case; a later option replaces\n"
      "an earlier one. A name that is unknown, or that the run does not use, ends the run.\n"
      "\n"
      "- Unit: of the value; `-` is a pure number, `dx` the particle spacing.\n"
      "- Default: the value, or the choice it follows from; empty: nothing unless given; by the "
      "regime:\n"
      "  a row of the [last table](#defaults-by-the-regime).\n"
      "- Used by: the runs that read the option; empty: all.\n"
      "- L and U are the reference length and speed, nu the kinematic viscosity.\n",
      out);
  for (PetscInt t = 0; OptionTableGet(t); t++) {
    const OptionTable *table = OptionTableGet(t);

    if (!IsForAll(table)) continue;
    (void)fprintf(out, "\n## %s\n", table->title);
    PrintPlaces(out, table, PETSC_TRUE);
    PrintHead(out);
    PrintRows(out, table, PETSC_FALSE);
  }
  (void)fprintf(out, "\n## %s\n", EXPERT);
  PrintHead(out);
  for (PetscInt t = 0; OptionTableGet(t); t++) PrintRows(out, OptionTableGet(t), PETSC_TRUE);
}

/* VersionCommit - Returns the git commit of the program, empty if unknown */
const char *VersionCommit(void)
{
  return ISPH_COMMIT;
}

/* VersionPrint - Prints the versions of isph, PETSc, hypre, HDF5 and MPI. Needs neither PETSc nor
   MPI to be initialized. Versions are read from the libraries at run time, except for hypre, whose
   version is from the build of PETSc. */
void VersionPrint(FILE *out)
{
  PetscInt     major, minor, subminor;
  unsigned int h5[3]                               = {0, 0, 0};
  char         mpi[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int          length;

  (void)fprintf(out, "isph %s%s%s\n", ISPH_VERSION, ISPH_COMMIT[0] ? ", commit " : "", ISPH_COMMIT);
  (void)PetscGetVersionNumber(&major, &minor, &subminor, NULL);
  (void)fprintf(out, "PETSc %d.%d.%d, %d-bit indices\n", (int)major, (int)minor, (int)subminor,
                (int)(8 * sizeof(PetscInt)));
#if defined(PETSC_PKG_HYPRE_VERSION_MAJOR)
  (void)fprintf(out, "hypre %d.%d.%d\n", PETSC_PKG_HYPRE_VERSION_MAJOR,
                PETSC_PKG_HYPRE_VERSION_MINOR, PETSC_PKG_HYPRE_VERSION_SUBMINOR);
#else
  (void)fprintf(out, "hypre absent from this PETSc\n");
#endif
  (void)H5get_libversion(&h5[0], &h5[1], &h5[2]);
  (void)fprintf(out, "HDF5 %u.%u.%u\n", h5[0], h5[1], h5[2]);
  (void)MPI_Get_library_version(mpi, &length);
  (void)fprintf(out, "%.*s\n", (int)strcspn(mpi, ",\n"), mpi);
}
