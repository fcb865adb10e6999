/*
  Tables and options: names in each table are unique and found, valid values are read, and invalid
  values are refused with the option and the value in the message.
*/
/* RANKS: 1 2 */
#include <string.h>
#include "cloud.h"
#include "isph/catalogue.h"

/* Type and result of an option, for the single function that reads options of every type. */
typedef struct {
  enum {
    READ_REAL,
    READ_INT,
    READ_SWITCH,
    READ_REALS,
    READ_FLAGS,
    READ_TABLE,
    READ_FILE,
    READ_UNKNOWN,
    READ_TOGETHER
  } what;
  PetscReal       real, reals[3];
  PetscInt        integer, n;
  PetscBool       on;
  unsigned        flags;
  const TableRow *row;
  char            path[PETSC_MAX_PATH_LEN];
  PetscBool       set;
  char            message[512];
} Reading;

static const char *const colours[] = {"red", "green", "blue", NULL};
static const OptionRow   options[] = {
      [READ_REAL] =
          {.name = "-t_real", .kind = VALUE_REAL, .standard = "0.25", .low = -1.5, .high = 2.5},
      [READ_INT]    = {.name = "-t_int", .kind = VALUE_INT, .standard = "5", .low = -3, .high = 7},
      [READ_SWITCH] = {.name = "-t_switch", .kind = VALUE_SWITCH, .standard = "false"},
      [READ_REALS]  = {.name = "-t_reals", .kind = VALUE_REALS},
      [READ_FLAGS]  = {.name = "-t_flags", .kind = VALUE_NAMES, .words = colours},
      [READ_TABLE]  = {.name     = "-t_table",
                       .kind     = VALUE_NAME,
                       .standard = "wendland_c2",
                       .table    = &KernelTable},
      [READ_FILE]   = {.name = "-t_file", .kind = VALUE_FILE},
};

static PetscErrorCode ReadOne(Reading *r)
{
  const OptionRow *row = r->what < READ_UNKNOWN ? &options[r->what] : NULL;

  switch (r->what) {
  case READ_REAL:
    return OptionGetReal(row, &r->real, &r->set);
  case READ_INT:
    return OptionGetInt(row, &r->integer, &r->set);
  case READ_SWITCH:
    return OptionGetSwitch(row, &r->on, &r->set);
  case READ_REALS:
    return OptionGetReals(row, 3, r->reals, &r->n, &r->set);
  case READ_FLAGS:
    return OptionGetFlags(row, &r->flags);
  case READ_TABLE:
    return OptionGetRow(row, NULL, &r->row);
  case READ_FILE:
    return OptionGetFile(row, r->path);
  case READ_UNKNOWN:
    return OptionsRefuseUnknown(PETSC_FALSE);
  default:
    return OptionsRefuseTogether("-dt", "-cfl", "of the test");
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
  code = ReadOne(r);
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

      assert_true(row->brief[0] != '\0');
      assert_in_range(strlen(row->name), 1, 127); /* as options have */
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
  AssertRefused("-t_table", "Wendland_C2 ", &r);
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

static void test_switch(void **state)
{
  Reading r = {.what = READ_SWITCH, .on = PETSC_TRUE};

  (void)state;
  AssertTaken(NULL, NULL, &r);
  assert_true(!r.on && !r.set);
  AssertTaken("-t_switch", NULL, &r);
  assert_true(r.on && r.set);
  AssertTaken("-t_switch", "no", &r);
  assert_true(!r.on && r.set);
  AssertTaken("-t_switch", "TRUE", &r);
  assert_true(r.on);
  AssertRefused("-t_switch", "perhaps", &r);
}

static void test_reals(void **state)
{
  static const char *const wrong[] = {"1,,2", "1,2,3,4", "a", "1,b", "1 2", "1,nan", "inf"};
  Reading                  r       = {.what = READ_REALS};

  (void)state;
  AssertTaken(NULL, NULL, &r);
  assert_true(r.n == 0 && !r.set);
  AssertTaken("-t_reals", "1,-2.5e-1,0.1", &r);
  assert_true(r.n == 3 && r.reals[0] == 1.0 && r.reals[1] == -0.25 && r.reals[2] == 0.1);
  AssertTaken("-t_reals", "7", &r);
  assert_true(r.n == 1 && r.reals[0] == 7.0 && r.set);
  AssertRefused("-t_reals", NULL, &r);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(wrong); k++)
    assert_int_equal(Read("-t_reals", wrong[k], &r), PETSC_ERR_USER_INPUT);
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

/* An unread option is refused, with the nearest known name in the message; a read option is not. */
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

/* Every option row is found by its name and has all required members, and no name occurs twice. */
static void test_rows(void **state)
{
  (void)state;
  for (PetscInt t = 0; OptionTableGet(t); t++) {
    const OptionTable *table = OptionTableGet(t);
    const OptionRow   *row;

    assert_true(table->count > 0 && table->title[0]);
    for (PetscInt k = 0; (row = OptionNext(table, &k));) {
      char      name[OPTION_LENGTH];
      OptionRow one;

      assert_true(row->name[0] == '-' && strlen(row->name) < OPTION_LENGTH - 32);
      assert_true(row->brief && row->brief[0]);
      if (row->kind == VALUE_NAME) assert_non_null(row->table);
      assert_true((row->kind == VALUE_NAMES || (row->kind == VALUE_VIEWER && row->early)) ==
                  (row->words != NULL));
      if (row->early) /* the kinds that src/options/optionsfile.c checks */
        assert_true(row->kind == VALUE_SWITCH || row->kind == VALUE_VIEWER ||
                    row->kind == VALUE_FILE);
      if (row->kind == VALUE_REAL) assert_true(row->unit && row->low < row->high);
      if (row->kind == VALUE_INT) assert_true(row->low < row->high);
      OptionFill(row, row->places ? row->places[0] : "1", name, &one);
      assert_ptr_equal(OptionFind(name), row); /* the only row of that name */
    }
  }
}

/* An option chooses from each table of the catalogue. */
static void test_tables_have_options(void **state)
{
  (void)state;
  for (PetscInt c = 0; CatalogueTable(c); c++) {
    PetscInt options_of_table = 0;

    for (PetscInt t = 0; OptionTableGet(t); t++) {
      const OptionRow *row;

      for (PetscInt k = 0; (row = OptionNext(OptionTableGet(t), &k));)
        if (row->table == CatalogueTable(c) || row->table_3d == CatalogueTable(c))
          options_of_table++;
    }
    assert_true(options_of_table > 0);
  }
}

/* Names that contain a number or a side, such as -scene_body_3, are found by their pattern; a
   suggestion is made only if a known name is near. */
static void test_names(void **state)
{
  static const char *const far[]     = {"-foo", "-grid", "-output_directory_of_the_run", "-q"};
  static const char *const near[][2] = {{"-reynold", "-reynolds"},
                                        {"-nu", "-viscosity"},
                                        {"--case", "-case"},
                                        {"-tend", "-t_end"},
                                        {"-catalog", "-catalogue"},
                                        {"-scene_bodie_3", "-scene_body_3"},
                                        {"-scene_body_12_velocty", "-scene_body_12_velocity"},
                                        {"-scene_wall_topp_velocity", "-scene_wall_top_velocity"},
                                        {"-ppe_kps_rtol", "-ppe_ksp_rtol"},
                                        {"-pressure_ponts", "-pressure_points"}};
  char                     nearest[OPTION_LENGTH];

  (void)state;
  assert_non_null(OptionFind("-scene_body_16_rotation"));
  assert_non_null(OptionFind("-check_u_min"));
  assert_non_null(OptionFind("-Reynolds")); /* PETSc's names have no case */
  assert_non_null(OptionFind("-coupled_fieldsplit_velocity_ksp_type"));
  assert_null(OptionFind("-scene_body_x"));
  assert_null(OptionFind("-scene_body_"));
  assert_non_null(OptionFind("-scene_wall_front_velocity"));
  assert_null(OptionFind("-scene_wall_side_velocity"));
  assert_null(OptionFind("-reynolds_2"));
  assert_null(OptionFind("--case"));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(near); k++) {
    assert_non_null(OptionNearest(near[k][0], nearest));
    assert_string_equal(nearest, near[k][1]);
  }
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(far); k++)
    assert_null(OptionNearest(far[k], nearest));
}

/* An option that is in no table cannot be read. */
static void test_no_row(void **state)
{
  PetscBool given;
  char      message[512];

  (void)state;
  assert_int_equal(PetscPushErrorHandler(CloudKeepMessage, message), PETSC_SUCCESS);
  assert_int_equal(OptionGiven("-no_such_option", &given), PETSC_ERR_PLIB);
  assert_int_equal(PetscPopErrorHandler(), PETSC_SUCCESS);
}

static void test_together(void **state)
{
  Reading r = {.what = READ_TOGETHER};

  (void)state;
  AssertTaken("-dt", "1", &r);
  AssertTaken("-cfl", "1", &r);
  assert_int_equal(PetscOptionsSetValue(NULL, "-cfl", "1"), PETSC_SUCCESS);
  AssertRefused("-dt", NULL, &r);
  assert_non_null(strstr(r.message, "-cfl"));
  assert_int_equal(PetscOptionsClearValue(NULL, "-cfl"), PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_tables),  cmocka_unit_test(test_table_select),
      cmocka_unit_test(test_real),    cmocka_unit_test(test_int),
      cmocka_unit_test(test_flags),   cmocka_unit_test(test_file),
      cmocka_unit_test(test_unknown), cmocka_unit_test(test_together),
      cmocka_unit_test(test_switch),  cmocka_unit_test(test_reals),
      cmocka_unit_test(test_rows),    cmocka_unit_test(test_tables_have_options),
      cmocka_unit_test(test_names),   cmocka_unit_test(test_no_row),
  };
  int failed;

  OptionsKnow(CatalogueOptions);
  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
