/*
  Fuzzer of restarts. A run writes a checkpoint; an input describes changes of a copy of this file,
  from which another run restarts. Changes by HDF5 give attributes and data sets other values, types
  and sizes, or remove them; changes of single bytes damage the structure of the file. The first
  byte tells if the checksum is corrected, so that a restart continues behind it.
*/
#include "fuzzer.h"
#include "isph/cases.h"
#include "run/checkpoint.h"
#include <stdlib.h>
#include <string.h>

#define PRISTINE    "pristine.h5"
#define CHANGED     "changed.h5"
#define MOST_NAMES  64
#define MOST_EDITS  8
#define MOST_BYTES  8192   /* of a text or of the values of a new data set */
#define MOST_VALUES 100000 /* of a data set that is read for the checksum */

typedef struct {
  char name[MOST_NAMES][64];
  int  n;
} Names;

/* A byte of the file that is overwritten after all other changes. */
typedef struct {
  size_t  place;
  uint8_t byte[8];
  size_t  n;
} Damage;

static Names    attributes, tables; /* of the file */
static uint8_t *image;              /* its bytes */
static size_t   image_size;
static Scene   *scene;
static Run      run;

static herr_t KeepAttribute(hid_t object, const char *name, const H5A_info_t *info, void *kept)
{
  Names *names = kept;

  if (names->n < MOST_NAMES)
    (void)snprintf(names->name[names->n++], sizeof(names->name[0]), "%s", name);
  return 0;
}

static herr_t KeepLink(hid_t group, const char *name, const H5L_info_t *info, void *kept)
{
  return KeepAttribute(group, name, NULL, kept);
}

/* Reads the bytes of the checkpoint and the names in it. */
static void ReadPristine(void)
{
  FILE *file = fopen(PRISTINE, "rb");
  hid_t h5;

  if (!file || fseek(file, 0, SEEK_END)) abort();
  image_size = (size_t)ftell(file);
  image      = malloc(image_size);
  rewind(file);
  if (!image || fread(image, 1, image_size, file) != image_size || fclose(file)) abort();
  h5 = H5Fopen(PRISTINE, H5F_ACC_RDONLY, H5P_DEFAULT);
  (void)H5Aiterate2(h5, H5_INDEX_NAME, H5_ITER_INC, NULL, KeepAttribute, &attributes);
  (void)H5Literate(h5, H5_INDEX_NAME, H5_ITER_INC, NULL, KeepLink, &tables);
  if (H5Fclose(h5) < 0 || !attributes.n || !tables.n) abort();
}

/* Sets options "-a", "b", ... */
static void SetOptions(const char *const words[])
{
  for (size_t k = 0; words[k]; k += 2)
    if (PetscOptionsSetValue(NULL, words[k], words[k + 1])) abort();
}

static void CreateRun(void)
{
  run = (Run){.flow = {.scene = scene}};
  if (RunCreate(&run)) abort();
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  static const char *const common[] = {"-n",
                                       "4",
                                       "-t_end",
                                       "1",
                                       "-max_steps",
                                       "2",
                                       "-dt",
                                       "0.01",
                                       "-report_times",
                                       "0.01",
                                       "-output",
                                       "snap.h5",
                                       "-output_every",
                                       "0.01",
                                       "-progress",
                                       "none",
                                       NULL};

  FuzzerStart();
  SetOptions(common);
  SetOptions((const char *const[]){"-checkpoint", PRISTINE, NULL});
  if (SceneCreate(&CaseOption, NULL, &scene)) abort();
  CreateRun();
  if (RunBegin(&run)) abort();
  while (!run.over)
    if (RunStep(&run)) abort();
  if (RunDestroy(&run)) abort();
  if (PetscOptionsClearValue(NULL, "-checkpoint")) abort();
  (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  ReadPristine();
  SetOptions((const char *const[]){"-restart", CHANGED, NULL});
  CreateRun();
  return 0;
}

/* ---- changes by HDF5 ---- */

/* Creates the type that a byte chooses; the caller closes it. */
static hid_t MakeType(FuzzerInput *input)
{
  const hid_t plain[] = {H5T_NATIVE_DOUBLE,  H5T_NATIVE_INT,   H5T_NATIVE_LLONG, H5T_NATIVE_UINT64,
                         H5T_NATIVE_CHAR,    H5T_NATIVE_FLOAT, H5T_IEEE_F64BE,   H5T_UNIX_D32LE,
                         H5T_NATIVE_LDOUBLE, H5T_NATIVE_B32,   H5T_STD_REF_OBJ};
  const unsigned choice = FuzzerByte(input) % 17;
  const hsize_t  length = 1 + FuzzerByte(input) % 4;
  hid_t          type;

  if (choice < PETSC_STATIC_ARRAY_LENGTH(plain)) return H5Tcopy(plain[choice]);
  switch (choice) {
  case 11:
  case 12:
    type = H5Tcopy(H5T_C_S1);
    (void)H5Tset_size(type, choice == 11 ? 16 * length * length : H5T_VARIABLE);
    return type;
  case 13:
    return H5Tarray_create2(H5T_NATIVE_DOUBLE, 1, &length);
  case 14:
    type = H5Tcreate(H5T_COMPOUND, 16);
    (void)H5Tinsert(type, "a", 0, H5T_NATIVE_DOUBLE);
    (void)H5Tinsert(type, "b", 8, H5T_NATIVE_DOUBLE);
    return type;
  case 15:
    return H5Tvlen_create(H5T_NATIVE_DOUBLE);
  default:
    return H5Tcreate(H5T_OPAQUE, 8);
  }
}

/* Creates a space of up to three dimensions, some of them large; the caller closes it. */
static hid_t MakeSpace(FuzzerInput *input, hsize_t size[3], int *rank)
{
  static const hsize_t large[] = {1000,
                                  65536,
                                  1 << 20,
                                  PETSC_INT_MAX / 33,
                                  PETSC_INT_MAX / 16,
                                  PETSC_INT_MAX,
                                  (hsize_t)1 << 32,
                                  (hsize_t)1 << 40};
  const unsigned       choice  = FuzzerByte(input);

  *rank = (int)(choice % 5);
  if (*rank == 4) {
    *rank = 0;
    return H5Screate(H5S_NULL);
  }
  for (int k = 0; k < *rank; k++) {
    const unsigned byte = FuzzerByte(input);

    size[k] = byte < 240 ? byte : large[byte % PETSC_STATIC_ARRAY_LENGTH(large)];
  }
  return *rank ? H5Screate_simple(*rank, size, NULL) : H5Screate(H5S_SCALAR);
}

/* Writes values of the input to a data set or an attribute that is small and has a plain type. */
static void WriteValues(FuzzerInput *input, hid_t object, hid_t type, hid_t space, PetscBool table)
{
  const hssize_t n     = H5Sget_simple_extent_npoints(space);
  const size_t   bytes = H5Tget_size(type);
  unsigned char *values;
  size_t         given;

  if (n <= 0 || (size_t)n > MOST_BYTES / PetscMax(bytes, 1)) return;
  if (H5Tis_variable_str(type) > 0 || H5Tget_class(type) == H5T_VLEN) return;
  values = calloc((size_t)n, bytes);
  if (!values) abort();
  given = FuzzerByte(input);
  (void)FuzzerBytes(input, PetscMin(given, (size_t)n * bytes), values);
  if (table) (void)H5Dwrite(object, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  else (void)H5Awrite(object, type, values);
  free(values);
}

/* Replaces an attribute by another type and size. */
static void ReplaceAttribute(FuzzerInput *input, hid_t file, const char name[])
{
  hsize_t     size[3] = {0};
  int         rank;
  const hid_t type = MakeType(input), space = MakeSpace(input, size, &rank);
  hid_t       attribute;

  (void)H5Adelete(file, name);
  attribute = H5Acreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  if (attribute >= 0) {
    WriteValues(input, attribute, type, space, PETSC_FALSE);
    (void)H5Aclose(attribute);
  }
  (void)H5Sclose(space);
  (void)H5Tclose(type);
}

/* Replaces a data set by another type, size and layout. */
static void ReplaceTable(FuzzerInput *input, hid_t file, const char name[])
{
  hsize_t     size[3] = {0}, chunk[3] = {1, 1, 1};
  int         rank;
  const hid_t type = MakeType(input), space = MakeSpace(input, size, &rank);
  const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
  hid_t       table;

  if (rank && FuzzerByte(input) % 2) {
    for (int k = 0; k < rank; k++) chunk[k] = PetscMax(PetscMin(size[k], 64), 1);
    (void)H5Pset_chunk(layout, rank, chunk);
  } else {
    (void)H5Pset_alloc_time(layout, H5D_ALLOC_TIME_LATE);
  }
  (void)H5Ldelete(file, name, H5P_DEFAULT);
  table = H5Dcreate2(file, name, type, space, H5P_DEFAULT, layout, H5P_DEFAULT);
  if (table >= 0) {
    WriteValues(input, table, type, space, PETSC_TRUE);
    (void)H5Dclose(table);
  }
  (void)H5Pclose(layout);
  (void)H5Sclose(space);
  (void)H5Tclose(type);
}

/* Overwrites bytes of an attribute of fixed size. */
static void ChangeAttribute(FuzzerInput *input, hid_t file, const char name[])
{
  const hid_t    attribute = H5Aopen(file, name, H5P_DEFAULT);
  const hid_t    type      = H5Aget_type(attribute);
  const size_t   bytes     = H5Tget_size(type);
  unsigned char *value     = bytes && bytes < 65536 ? calloc(1, bytes) : NULL;

  if (value && H5Tis_variable_str(type) <= 0 && H5Aget_storage_size(attribute) == bytes) {
    const size_t first = FuzzerByte(input) % bytes, given = 1 + FuzzerByte(input) % 64;

    (void)H5Aread(attribute, type, value);
    (void)FuzzerBytes(input, PetscMin(given, bytes - first), value + first);
    (void)H5Awrite(attribute, type, value);
  }
  free(value);
  (void)H5Tclose(type);
  (void)H5Aclose(attribute);
}

/* Overwrites a number of a table. */
static void ChangeTable(FuzzerInput *input, hid_t file, const char name[])
{
  static const double odd[] = {0.0,   -1.0, 1.0,   0.5,    2.0,  1e9,  3e9,      -3e9,
                               1e300, NAN,  1e-30, 1e-300, -1e5, 1e16, INFINITY, 12345678.0};
  const hid_t         table = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(table);
  const hssize_t      n      = H5Sget_simple_extent_npoints(space);
  double             *values = n > 0 && n < MOST_VALUES ? calloc((size_t)n, sizeof(*values)) : NULL;

  if (values && H5Dread(table, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0) {
    const size_t   place  = (FuzzerByte(input) + 256 * FuzzerByte(input)) % (size_t)n;
    const unsigned choice = FuzzerByte(input);

    if (choice < 128) values[place] = odd[choice % PETSC_STATIC_ARRAY_LENGTH(odd)];
    else if (choice < 192) values[place] += choice - 160.0;
    else (void)FuzzerBytes(input, sizeof(*values), &values[place]);
    (void)H5Dwrite(table, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  }
  free(values);
  (void)H5Sclose(space);
  (void)H5Dclose(table);
}

/* Puts a link, a group or another data set in the place of a data set, or nothing. */
static void ReplaceLink(FuzzerInput *input, hid_t file, const char name[])
{
  const char *const other  = tables.name[FuzzerByte(input) % (unsigned)tables.n];
  const unsigned    choice = FuzzerByte(input) % 5;

  (void)H5Ldelete(file, name, H5P_DEFAULT);
  if (choice == 0) (void)H5Lcreate_soft(other, file, name, H5P_DEFAULT, H5P_DEFAULT);
  if (choice == 1) (void)H5Lcreate_external(PRISTINE, other, file, name, H5P_DEFAULT, H5P_DEFAULT);
  if (choice == 2) (void)H5Lcreate_hard(file, other, file, name, H5P_DEFAULT, H5P_DEFAULT);
  if (choice == 3) (void)H5Gclose(H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
}

/* ---- the checksum ---- */

/* Adds a table to the checksum as a restart does: all numbers together, or row by row. */
static void SumTable(Hdf5File *file, const char name[], PetscBool by_rows, uint64_t *sum)
{
  PetscInt N, columns;
  double  *values;

  if (Hdf5CountRows(file, name, &N, &columns)) abort();
  if (N <= 0 || columns <= 0 || N > MOST_VALUES / columns) return;
  values      = calloc((size_t)(N * columns), sizeof(*values));
  file->start = 0;
  file->own = file->N = N;
  if (!values || Hdf5ReadRows(file, name, columns, H5T_NATIVE_DOUBLE, values)) abort();
  if (by_rows && CheckpointSumRecords(N, columns, values, sum)) abort();
  if (!by_rows) CheckpointSumNumbers(N * columns, values, sum);
  free(values);
}

/* Makes the checksum of a changed file right. */
static void CorrectSum(hid_t h5)
{
  const char *const texts[] = {"memory_names", "report_names"};
  Hdf5File          file    = {.comm = PETSC_COMM_SELF, .file = h5, .transfer = H5P_DEFAULT};
  long long         next_id = 0;
  uint64_t          sum     = 0;
  char              text[MEMORY_MAX * 32];
  double            next;

  (void)Hdf5ReadNumber(&file, "next_id", H5T_NATIVE_LLONG, &next_id);
  next = (double)next_id;
  CheckpointSumNumbers(1, &next, &sum);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(texts); k++) {
    (void)Hdf5ReadText(&file, texts[k], text, sizeof(text));
    CheckpointSumText(text, &sum);
  }
  for (int k = 0; k < tables.n; k++)
    SumTable(&file, tables.name[k], strcmp(tables.name[k], "particles") ? PETSC_FALSE : PETSC_TRUE,
             &sum);
  (void)H5Adelete(h5, "checksum");
  if (Hdf5WriteNumber(&file, "checksum", H5T_NATIVE_UINT64, &sum)) abort();
}

/* ---- an input ---- */

/* Notes bytes of the file to be overwritten; most are in its structure, at the beginning. */
static void NoteDamage(FuzzerInput *input, Damage *damage)
{
  const unsigned low = FuzzerByte(input);

  damage->place = (low + 256 * FuzzerByte(input)) % image_size;
  damage->n     = FuzzerBytes(input, 1 + FuzzerByte(input) % sizeof(damage->byte), damage->byte);
}

/* Writes the changed file. */
static void WriteChanged(FuzzerInput *input)
{
  const unsigned corrects = FuzzerByte(input) % 4, edits = 1 + FuzzerByte(input) % MOST_EDITS;
  Damage         damage[MOST_EDITS];
  unsigned       damages = 0;
  hid_t          h5;
  FILE          *file;

  FuzzerWrite(CHANGED, image, image_size);
  h5 = H5Fopen(CHANGED, H5F_ACC_RDWR, H5P_DEFAULT);
  for (unsigned k = 0; k < edits && input->left; k++) {
    const unsigned    choice = FuzzerByte(input) % 8, name = FuzzerByte(input);
    const char *const attribute = attributes.name[name % (unsigned)attributes.n];
    const char *const table     = tables.name[name % (unsigned)tables.n];

    if (choice == 0) ChangeAttribute(input, h5, attribute);
    if (choice == 1) ReplaceAttribute(input, h5, attribute);
    if (choice == 2) (void)H5Adelete(h5, attribute);
    if (choice == 3 || choice == 4) ChangeTable(input, h5, table);
    if (choice == 5) ReplaceTable(input, h5, table);
    if (choice == 6) ReplaceLink(input, h5, table);
    if (choice == 7) NoteDamage(input, &damage[damages++]);
  }
  if (corrects) CorrectSum(h5);
  (void)H5Fclose(h5);
  if (!damages) return;
  file = fopen(CHANGED, "r+b");
  if (!file) abort();
  for (unsigned k = 0; k < damages; k++) {
    (void)fseek(file, (long)damage[k].place, SEEK_SET);
    (void)fwrite(damage[k].byte, 1, damage[k].n, file);
  }
  (void)fclose(file);
}

/*
  Restarts the run from the changed file. A refusal before the particles are replaced leaves the run
  usable; the objects that it leaves open in HDF5 are closed here. After a failure within the start
  of the new flow the run is given up.
*/
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  FuzzerInput    input = {data, size};
  const PetscInt epoch = run.flow.particles->epoch;
  PetscErrorCode failed;

  WriteChanged(&input);
  failed = RunBegin(&run);
  (void)H5close();
  (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  if (!failed && RunDestroy(&run)) abort();
  if (!failed || run.flow.particles->epoch != epoch) CreateRun();
  return 0;
}
