/* Foundation of all modules: PETSc, the version, tables of named rows, errors of the user, and
   files. */
#ifndef ISPH_BASE_H
#define ISPH_BASE_H

#include "isph/petsc.h"

#define ISPH_VERSION "0.2.0"
#define ISPH_MAX_DIM 3

/* ISPH_WIDE compiles a function twice: for all x86-64 processors, and for those with vectors of
   four numbers. The loader takes the version that fits. Both have the same operations, without
   fused multiply-add, so results are equal to the last bit. ISPH_INLINE marks the functions that
   have to become part of both versions; under the sanitizers, which take ten times as long to
   compile them, there is one version. */
#ifdef __SANITIZE_ADDRESS__
#define ISPH_INLINE inline
#else
#define ISPH_INLINE inline __attribute__((always_inline))
#endif
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) &&       \
    !defined(__AVX2__) && !defined(__SANITIZE_ADDRESS__)
#define ISPH_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define ISPH_WIDE
#endif

/* A table is a const array of structs that all begin with these three members. Options choose a row
   by its name; only src/base/table.c compares names. */
typedef struct {
  const char *name;     /* value of the option */
  const char *brief;    /* description in a line */
  const char *citation; /* publication; NULL: none */
} TableRow;

typedef struct {
  const char *title;    /* plural heading in the catalogue, e.g. "Kernels" */
  const void *rows;     /* structs, or pointers to structs */
  size_t      row_size; /* bytes; 0: pointers */
  PetscInt    count;
  PetscErrorCode (*Describe)(const TableRow *row, char text[], size_t length); /* or NULL */
} Table;

/* A table with a function that describes the declared properties of a row, for the catalogue. */
#define TABLE_DESCRIBED(title, rows, Describe)                                                     \
  {                                                                                                \
    title, rows, sizeof((rows)[0]), (PetscInt)(sizeof(rows) / sizeof((rows)[0])), Describe         \
  }
#define TABLE(title, rows) TABLE_DESCRIBED(title, rows, NULL)

/* A table whose rows are defined in separate files, as the table of schemes. */
#define TABLE_OF_POINTERS(title, rows)                                                             \
  {                                                                                                \
    title, rows, 0, (PetscInt)(sizeof(rows) / sizeof((rows)[0])), NULL                             \
  }

PetscErrorCode  TableExtend(const Table *table, const Table *rows);
PetscInt        TableCount(const Table *table);
const TableRow *TableGet(const Table *table, PetscInt k);
PetscErrorCode  TableFind(const Table *table, const char name[], const TableRow **row);
PetscErrorCode  TableWant(const Table *table, const char option[], const char name[], void *row);
PetscErrorCode  TableView(const Table *table, const char options[], PetscViewer viewer);
PetscErrorCode  TableViewRow(const char label[], const void *row, PetscViewer viewer);
void            TextAppend(char text[], size_t size, const char more[]);
void            AppendWord(char list[], size_t size, const char word[]);

/* Free several arrays, vectors or matrices, given by the addresses of their pointers. */
#define FreeAll(...)       FreeArrays(__VA_ARGS__, NULL)
#define VecDestroyAll(...) ObjectsDestroy(__VA_ARGS__, NULL)
#define MatDestroyAll(...) ObjectsDestroy(__VA_ARGS__, NULL)
PetscErrorCode FreeArrays(void *first, ...) __attribute__((sentinel));
PetscErrorCode ObjectsDestroy(void *first, ...) __attribute__((sentinel));

/* Checks a condition that the user must meet. Errors that the user can correct (an option, a file,
   a diverged solve) end the run with a message of one line instead of a traceback; ErrorsInstall()
   and ErrorsExit() do this. The text of UserCheck() gives the option, its value and the allowed
   values. Collective: the condition must be the same on all ranks. */
#define UserCheck(condition, ...)                                                                  \
  PetscCheck(condition, PETSC_COMM_WORLD, PETSC_ERR_USER_INPUT, __VA_ARGS__)
/* Error code of a run that a signal interrupted, 128 plus its number; also its exit status, as of a
   program that the signal ends in a shell. */
#define ERROR_INTERRUPTED(signal) ((PetscErrorCode)(128 + (signal)))
PetscErrorCode InterruptInstall(void);
PetscErrorCode InterruptCheck(PetscMPIInt *signal);
const char    *InterruptName(PetscMPIInt signal);

/* An error as it was found, for a handler that deals with it later. */
typedef struct {
  MPI_Comm    comm;
  int         line;
  const char *function, *file; /* NULL: there was none */
  const char *hint;            /* the end of the message */
  char        message[1024];
} KeptError;

/* State of the error handler for ErrorsExit(). */
typedef struct {
  PetscBool keeps; /* ErrorsKeep(): messages of errors of the user are not printed */
  KeptError kept;
  PetscBool of_one_rank; /* a single rank met an error that all ranks normally detect together */
  PetscBool of_solver;   /* PETSc failed with a solver that the user chose */
} ErrorState;

extern const char *const SolverPrefixes[]; /* of options of PETSc's solvers; ends with NULL */

PetscErrorCode ErrorsInstall(ErrorState *state);
void           ErrorPrint(const char message[], const char hint[]);
PetscErrorCode ErrorsKeep(ErrorState *state);
PetscErrorCode ErrorsRelease(PetscErrorCode code, const ErrorState *state);
int            ErrorsExit(PetscErrorCode code, const ErrorState *state);
PetscErrorCode FirstRankDecides(PetscBool *verdict);
PetscErrorCode SayLine(const char format[], ...) PETSC_ATTRIBUTE_FORMAT(1, 2);

void      PrepareMpi(void);
PetscBool HasLauncher(void);

PetscErrorCode PathBesideProgram(const char relative[], char path[PETSC_MAX_PATH_LEN]);

/* Files that a run writes. */
PetscBool      FileIsOrdinary(const char path[]);
PetscBool      FileIsReadable(const char path[]);
FILE          *FileOpen(const char path[], const char mode[]);
PetscBool      FileReplace(const char part[], const char path[]);
PetscErrorCode ViewerCheck(PetscViewer viewer, const char option[]);
PetscErrorCode FileReserve(const char path[], size_t bytes, PetscBool *good);
PetscErrorCode CsvRead(FILE *stream, PetscInt *rows, PetscInt *columns, PetscReal **value,
                       PetscInt *bad);

#endif
