/*
  Tables and options: names in each table are unique and found, typed values arrive, and mistyped
  values are refused with the option and the value in the message.
*/
/* RANKS: 1 2 */
#include <string.h>
#include "cloud.h"
#include "isph/catalogue.h"

/* Type and result of an option, for the single function that reads options of every type. */
typedef struct {
  enum { READ_REAL, READ_INT, READ_FLAGS, READ_TABLE, READ_FILE, READ_UNKNOWN, READ_TOGETHER } what;
  PetscReal       real;
  PetscInt        integer;
  unsigned        flags;
  const TableRow *row;
  char            path[PETSC_MAX_PATH_LEN];
  PetscBool       set;
  char            message[512];
} Reading;

static const char *const colours[] = {"red", "green", "blue"};

static PetscErrorCode ReadOne(OptionItems PetscOptionsObject, Reading *r)
{
  switch (r->what) {
  case READ_REAL:
    return OptionReal("-t_real", "a number", -1.5, 2.5, &r->real, &r->set);
  case READ_INT:
    return OptionInt("-t_int", "a whole number", -3, 7, &r->integer, &r->set);
  case READ_FLAGS:
    return OptionFlags("-t_flags", "colours", colours, 3, &r->flags);
  case READ_TABLE:
    return TableSelect(&KernelTable, "-t_table", "a row", "wendland_c2", &r->row);
  case READ_FILE:
    return OptionFile("-t_file", "a path", r->path);
  case READ_UNKNOWN:
    return OptionsRefuseUnknown(PETSC_FALSE);
  default:
    return OptionsRefuseTogether("-t_one", "-t_two", "of the test");
  }
}

/* Reads with "option value" in the database; option NULL: empty database, value NULL: no value. */
static PetscErrorCode Read(const char option[], const char value[], Reading *r)
{
  PetscErrorCode code = PETSC_SUCCESS;

  PetscFunctionBegin;
  r->message[0] = '\0';
  if (option) PetscCall(PetscOptionsSetValue(NULL, option, value));
  PetscCall(PetscPushErrorHandler(CloudKeepMessage, r->message));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Test", "");
  code = ReadOne(PetscOptionsObject, r);
  PetscOptionsEnd();
  PetscCall(PetscPopErrorHandler());
  if (option) PetscCall(PetscOptionsClearValue(NULL, option));
  PetscFunctionReturn(code);
}

static void AssertTaken(const char option[], const char value[], Reading *r)
{
  const PetscErrorCode code = Read(option, value, r);

  if (code)
    print_error("%s %s: refused: %s\n", option ? option : "", value ? value : "", r->message);
  assert_int_equal(code, PETSC_SUCCESS);
}

/* Requires an error of user input whose message names the option and, if given, the value. */
static void AssertRefused(const char option[], const char value[], Reading *r)
{
  const PetscErrorCode code = Read(option, value, r);

  if (code != PETSC_ERR_USER_INPUT)
    print_error("%s %s: code %d\n", option, value ? value : "", (int)code);
  assert_int_equal(code, PETSC_ERR_USER_INPUT);
  assert_non_null(strstr(r->message, option));
  if (value) assert_non_null(strstr(r->message, value));
}

static void test_tables(void **state)
{
  (void)state;
  for (PetscInt t = 0; CatalogueTable(t); t++) {
    const Table *table = CatalogueTable(t);

    assert_true(table->count > 0);
    for (PetscInt k = 0; k < table->count; k++) {
      const TableRow *row = TableGet(table, k), *found;

      assert_non_null(row->citation);
      assert_true(row->brief[0] != '\0');
      assert_in_range(strlen(row->name), 1, 127); /* length that TableSelect() reads */
      assert_null(strpbrk(row->name, " ,\t"));
      assert_int_equal(TableFind(table, row->name, &found), PETSC_SUCCESS);
      assert_ptr_equal(found, row); /* names are unique */
    }
  }
}

static void test_table_select(void **state)
{
  Reading r = {.what = READ_TABLE};

  (void)state;
  AssertTaken(NULL, NULL, &r);
  assert_string_equal(r.row->name, "wendland_c2");
  for (PetscInt k = 0; k < KernelTable.count; k++) {
    AssertTaken("-t_table", TableGet(&KernelTable, k)->name, &r);
    assert_ptr_equal(r.row, TableGet(&KernelTable, k));
  }
  AssertRefused("-t_table", "wendland", &r); /* no abbreviations */
  AssertRefused("-t_table", "Wendland_C2", &r);
  AssertRefused("-t_table", "wendland_c2x", &r);
  for (PetscInt k = 0; k < KernelTable.count; k++) /* the message lists all names */
    assert_non_null(strstr(r.message, TableGet(&KernelTable, k)->name));
}

static void test_real(void **state)
{
  static const char *const wrong[] = {"1,5",  "abc",       "1.0x", "nan",   "NaN", "inf",
                                      "-inf", "2.5000001", "-1.6", "1e400", "--1"};
  Reading                  r       = {.what = READ_REAL, .real = 0.25};

  (void)state;
  AssertTaken(NULL, NULL, &r);
  assert_true(r.real == 0.25 && !r.set);
  AssertTaken("-t_real", "1.25e-1", &r);
  assert_true(r.real == 0.125 && r.set);
  AssertTaken("-t_real", "-1.5", &r);
  assert_true(r.real == -1.5);
  AssertTaken("-t_real", "2.5", &r);
  assert_true(r.real == 2.5);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(wrong); k++) {
    AssertRefused("-t_real", wrong[k], &r);
    assert_true(r.real == 2.5);
  }
  AssertRefused("-t_real", NULL, &r);
}

static void test_int(void **state)
{
  static const char *const wrong[] = {
      "1.5", "abc", "2x", "nan", "1e0", "8", "-4", "99999999999999999999", "4294967297"};
  Reading r = {.what = READ_INT, .integer = 5};

  (void)state;
  AssertTaken(NULL, NULL, &r);
  assert_true(r.integer == 5 && !r.set);
  AssertTaken("-t_int", "-3", &r);
  assert_true(r.integer == -3 && r.set);
  AssertTaken("-t_int", "7", &r);
  assert_int_equal(r.integer, 7);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(wrong); k++) {
    AssertRefused("-t_int", wrong[k], &r);
    assert_int_equal(r.integer, 7);
  }
  AssertRefused("-t_int", NULL, &r);
}

static void test_flags(void **state)
{
  Reading r = {.what = READ_FLAGS, .flags = 99};

  (void)state;
  AssertTaken(NULL, NULL, &r);
  assert_int_equal(r.flags, 0);
  AssertTaken("-t_flags", "green", &r);
  assert_int_equal(r.flags, 2);
  AssertTaken("-t_flags", "blue,red", &r);
  assert_int_equal(r.flags, 5);
  AssertTaken("-t_flags", "red,red", &r);
  assert_int_equal(r.flags, 1);
  AssertRefused("-t_flags", "grey", &r);
  assert_non_null(strstr(r.message, "red, green, blue"));
  assert_int_equal(Read("-t_flags", "red,grey", &r), PETSC_ERR_USER_INPUT);
  assert_non_null(strstr(r.message, "grey"));
}

static void test_file(void **state)
{
  Reading r = {.what = READ_FILE};

  (void)state;
  AssertTaken(NULL, NULL, &r);
  assert_string_equal(r.path, "");
  AssertTaken("-t_file", "a/b c.csv", &r);
  assert_string_equal(r.path, "a/b c.csv");
  AssertRefused("-t_file", NULL, &r);
}

/* An unread option is refused with the nearest known name; a read option is not. */
static void test_unknown(void **state)
{
  Reading r = {.what = READ_UNKNOWN}, real = {.what = READ_REAL};

  (void)state;
  AssertTaken(NULL, NULL, &r);
  AssertRefused("-kernal", NULL, &r);
  assert_non_null(strstr(r.message, "-kernel"));
  assert_int_equal(Read("-visc_ksp_rtoll", "1e-3", &r), PETSC_ERR_USER_INPUT);
  assert_non_null(strstr(r.message, "-visc_ksp_rtoll"));
  assert_non_null(strstr(r.message, "-visc_ksp_rtol "));
  AssertTaken("-check_u_min", "0.1", &r); /* the report reads it later */
  AssertTaken("-t_real", "1.0", &real);
}

static void test_together(void **state)
{
  Reading r = {.what = READ_TOGETHER};

  (void)state;
  AssertTaken("-t_one", "1", &r);
  AssertTaken("-t_two", "1", &r);
  assert_int_equal(PetscOptionsSetValue(NULL, "-t_two", "1"), PETSC_SUCCESS);
  AssertRefused("-t_one", NULL, &r);
  assert_non_null(strstr(r.message, "-t_two"));
  assert_int_equal(PetscOptionsClearValue(NULL, "-t_two"), PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_tables),  cmocka_unit_test(test_table_select),
      cmocka_unit_test(test_real),    cmocka_unit_test(test_int),
      cmocka_unit_test(test_flags),   cmocka_unit_test(test_file),
      cmocka_unit_test(test_unknown), cmocka_unit_test(test_together),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
