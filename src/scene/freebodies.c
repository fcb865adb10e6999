/* Bodies that move as a file says, or are free to move: their mass and inertia, the forces on them
   besides those of the fluid, and the components of their motion that are held. A body is free if
   its density or its mass is given. */
#include "isph/scene.h"

enum { DENSITY, MASS, INERTIA, FORCE, TORQUE, SPRING, HOLD, FROM_FILE };
static const char *const components[] = {"x", "y", "z", "rotation", NULL};

static const OptionRow options[] = {
    [DENSITY] = OPTION(REAL, "-scene_body_<k>_density",
                       "density of a body, which is then free to move by the forces on it; its "
                       "-scene_body_<k>_velocity and _rotation are those at the start",
                       "kg/m^3", NULL, POSITIVE, .where = "-case scene, bodies that are given"),
    [MASS]    = OPTION(REAL, "-scene_body_<k>_mass",
                       "mass of a free body, in place of its density; in 2D per metre of depth",
                       "kg; kg/m", NULL, POSITIVE, .where = "-case scene, bodies that are given"),
    [INERTIA] =
        OPTION(REALS, "-scene_body_<k>_inertia",
               "moment of inertia of a free body about its centre; in 3D about x, y, z",
               "kg m^2; kg m", "that of a uniform density", .where = "-case scene, free bodies"),
    [FORCE]     = OPTION(EXPRESSION, "-scene_body_<k>_force",
                         "force on a free body besides those of the fluid and of -body_force, of t",
                         "N; N/m", "0", .where = "-case scene, free bodies"),
    [TORQUE]    = OPTION(EXPRESSION, "-scene_body_<k>_torque",
                         "torque on a free body about its centre, of t; in 3D about x, y, "
                            "z",
                         "N m; N", "0", .where = "-case scene, free bodies"),
    [SPRING]    = OPTION(REALS, "-scene_body_<k>_spring",
                         "stiffness kx,ky[,kz] of a spring that pulls the centre of a free "
                            "body back "
                            "to its place at the start",
                         "N/m; Pa", "0", .where = "-case scene, free bodies"),
    [HOLD]      = OPTION(NAMES, "-scene_body_<k>_hold",
                         "components of the motion of a free body that no force changes: they "
                              "follow "
                              "-scene_body_<k>_velocity and _rotation",
                         NULL, NULL, .words = components, .where = "-case scene, free bodies"),
    [FROM_FILE] = OPTION(FILE, "-scene_body_<k>_motion",
                         "CSV file of the motion of a body: rows t,x,y[,degrees] of its centre and "
                         "its turn from where it was typed; in 3D t,x,y,z[,ax,ay,az,degrees] about "
                         "one axis; cubics between the rows, with a continuous velocity",
                         "s, m, degrees", NULL,
                         .where = "-case scene, bodies that are given, particles that move",
                         .file  = FILE_READ),
};
const OptionTable FreeBodyOptions = OPTIONS("Bodies that are free, or follow a file", options);

/* Sets mass and inertia of a body of uniform density, with its mass or, if that is 0, density. */
static void SetInertia(const Scene *scene, const Body *body, PetscReal density, PetscReal mass,
                       Freedom *f)
{
  const PetscBool through = (PetscBool)(scene->dim == 3 && BodyReachesThrough(body, 2));
  PetscReal       trace   = 0.0;
  BodyMoments     m;

  BodyFindMoments(body, &m);
  f->volume = m.volume * (through ? body->ends[1] - body->ends[0] : 1.0);
  f->mass   = mass > 0.0 ? mass : density * f->volume;
  for (PetscInt a = 0; a < scene->dim; a++) trace += m.second[a][a];
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++)
    for (PetscInt b = 0; b < ISPH_MAX_DIM; b++)
      f->inertia[a][b] = f->mass / m.volume * ((a == b ? trace : 0.0) - m.second[a][b]);
}

/* Reads numbers of an option, `least` or `most` of them; others of value[] stay. */
static PetscErrorCode ReadNumbers(PetscInt option, PetscInt k, PetscInt wanted, PetscReal value[],
                                  PetscBool *given)
{
  char      name[OPTION_LENGTH];
  OptionRow row;
  PetscInt  n;

  PetscFunctionBegin;
  OptionNumber(&options[option], k, name, &row);
  PetscCall(OptionGetReals(&row, wanted, value, &n, given));
  UserCheck(!*given || n == wanted,
            "%s: %" PetscInt_FMT " numbers are required, got %" PetscInt_FMT, name, wanted, n);
  for (PetscInt c = 0; c < wanted; c++)
    UserCheck(!*given || value[c] >= 0.0, "%s: its numbers must not be negative", name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses options of free bodies for a body that is none. */
static PetscErrorCode RefuseBound(PetscInt k)
{
  char      name[OPTION_LENGTH];
  OptionRow row;
  PetscBool given;

  PetscFunctionBegin;
  for (PetscInt option = INERTIA; option <= HOLD; option++) {
    OptionNumber(&options[option], k, name, &row);
    PetscCall(OptionGiven(name, &given));
    UserCheck(!given,
              "%s: it is for bodies that move freely; give -scene_body_%" PetscInt_FMT
              "_density or -scene_body_%" PetscInt_FMT "_mass",
              name, k, k);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the held components: those of -scene_body_<k>_hold, those outside the plane in 2D, and those
   across the axis of a body that reaches through the box. */
static PetscErrorCode ReadHeld(const Scene *scene, PetscInt k, const Body *body, Freedom *f)
{
  const unsigned turns = 7u << FREEDOM_SPIN;
  char           name[OPTION_LENGTH];
  OptionRow      row;
  unsigned       words;

  PetscFunctionBegin;
  OptionNumber(&options[HOLD], k, name, &row);
  PetscCall(OptionGetFlags(&row, &words));
  UserCheck(scene->dim == 3 || !(words & 4u), "%s: z is of a box in 3D", name);
  f->held = (words & 7u) | (words & 8u ? turns : 0u);
  if (scene->dim == 2 || BodyReachesThrough(body, 2)) f->held |= 4u | 3u << FREEDOM_SPIN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses velocities of t in components that forces change: only those at the start are used. */
static PetscErrorCode RefuseGiven(const Scene *scene, const Boundary *boundary)
{
  const Freedom *f = &boundary->freedom;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++)
    UserCheck(
        f->held >> a & 1u || !(boundary->velocity.uses[a] & EXPRESSION_TIME),
        "%s: forces change the velocity of a free body along %s, so that it is a number, that "
        "at the start; or hold this component",
        boundary->velocity.option, components[a]);
  UserCheck(f->held >> (FREEDOM_SPIN + 2) & 1u ||
                !ExpressionUses(&boundary->rotation, EXPRESSION_TIME),
            "%s: torques change the rotation of a free body, so that it is a number, that at the "
            "start; or hold the rotation",
            boundary->rotation.option);
  UserCheck(!boundary->position.n, "%s: forces give the place of a free body",
            boundary->position.option);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneReadFreedom - Reads the freedom of body k = 1, 2, ..., whose shape and motion are known;
   collective. A body without density and mass is not free. Output: boundary->freedom. In 2D all are
   per metre of depth. */
PetscErrorCode SceneReadFreedom(Scene *scene, PetscInt k, Boundary *boundary)
{
  const PetscInt axes    = scene->dim == 3 ? 3 : 1;
  Freedom       *f       = &boundary->freedom;
  PetscReal      density = 0.0, mass = 0.0, inertia[ISPH_MAX_DIM];
  char           name[2][OPTION_LENGTH];
  OptionRow      row;
  PetscBool      given[2], set;

  PetscFunctionBegin;
  OptionNumber(&options[DENSITY], k, name[0], &row);
  PetscCall(OptionGetReal(&row, &density, &given[0]));
  OptionNumber(&options[MASS], k, name[1], &row);
  PetscCall(OptionGetReal(&row, &mass, &given[1]));
  UserCheck(!given[0] || !given[1], "%s and %s: one follows from the other; give one of them",
            name[0], name[1]);
  if (!given[0] && !given[1]) {
    PetscCall(RefuseBound(k));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  UserCheck(SceneMoves(scene) || !SceneHas(scene, PHYSICS_CONVECTION),
            "%s: a free body moves with particles that move; use -motion lagrangian, or -without "
            "convection for the velocity of a body in its place",
            name[given[1]]);
  boundary->free = scene->unsteady_walls = PETSC_TRUE;
  SetInertia(scene, &boundary->body, density, mass, f);
  PetscCall(ReadHeld(scene, k, &boundary->body, f));
  PetscCall(RefuseGiven(scene, boundary));
  PetscCall(ReadNumbers(INERTIA, k, axes, inertia, &set));
  for (PetscInt c = 0; set && c < ISPH_MAX_DIM; c++)
    for (PetscInt b = 0; b < ISPH_MAX_DIM; b++)
      f->inertia[c][b] = b == c ? inertia[axes == 3 ? c : 0] : 0.0;
  PetscCall(ReadNumbers(SPRING, k, scene->dim, f->spring, &set));
  UserCheck(!set || SceneMoves(scene),
            "-scene_body_%" PetscInt_FMT "_spring: without convection "
            "bodies stay where they are, and no spring pulls",
            k);
  OptionNumber(&options[FORCE], k, name[0], &row);
  PetscCall(
      ExpressionGet(scene->scope, &row, scene->dim, scene->dim, EXPRESSION_TIME, &f->force, NULL));
  OptionNumber(&options[TORQUE], k, name[0], &row);
  PetscCall(ExpressionGet(scene->scope, &row, axes, axes, EXPRESSION_TIME, &f->torque, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneHasFreeBodies - Returns true if a body moves by the forces on it */
PetscBool SceneHasFreeBodies(const Scene *scene)
{
  for (PetscInt k = 0; k < scene->n_bodies; k++)
    if (scene->boundary[SceneBodySide(scene, k)].free) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Makes component c of an expression the curve through column `column`, times `factor`, of rows. */
static PetscErrorCode SetCurve(Scene *scene, PetscInt rows, PetscInt columns,
                               const PetscReal value[], PetscInt column, PetscReal factor,
                               Expression *e)
{
  TimeCurve  *curve;
  PetscReal  *number; /* times, values, slopes */
  const char *fault;

  PetscFunctionBegin;
  PetscCall(PetscNew(&curve));
  PetscCall(BodyStoreAdd(curve, &scene->store));
  PetscCall(PetscMalloc1(3 * rows, &number));
  PetscCall(BodyStoreAdd(number, &scene->store));
  for (PetscInt k = 0; k < rows; k++) {
    number[k]        = value[k * columns];
    number[rows + k] = factor * value[k * columns + column];
  }
  *curve = (TimeCurve){.n = rows, .t = number, .y = number + rows, .slope = number + 2 * rows};
  fault  = TimeCurveSet(curve);
  UserCheck(!fault, "%s: %s", e->option, fault);
  e->curve[e->n]  = curve;
  e->uses[e->n++] = EXPRESSION_TIME;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the turn about the axis in the three columns before the last, the same in all rows with a
   turn; in 2D about z. */
static PetscErrorCode SetTurn(Scene *scene, PetscInt rows, PetscInt columns,
                              const PetscReal value[], Boundary *boundary)
{
  PetscReal axis[ISPH_MAX_DIM] = {0.0, 0.0, 1.0}, length = 1.0;
  PetscInt  bad = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < rows && scene->dim == 3; k++) {
    for (PetscInt a = 0; a < 3; a++)
      if (k && value[k * columns + 4 + a] != axis[a] && !bad) bad = k + 1;
    for (PetscInt a = 0; a < 3; a++) axis[a] = value[4 + a];
  }
  UserCheck(!bad,
            "%s: row %" PetscInt_FMT " has another axis than the first; a file turns a body about "
            "one axis, by any number of degrees",
            boundary->position.option, bad);
  length = PetscSqrtReal(PetscSqr(axis[0]) + PetscSqr(axis[1]) + PetscSqr(axis[2]));
  UserCheck(length > 0.0, "%s: the axis 0,0,0 has no direction", boundary->position.option);
  UserCheck((axis[0] == 0.0 && axis[1] == 0.0) || !BodyReachesThrough(&boundary->body, 2),
            "%s: a %s that reaches through the box stays along z", boundary->position.option,
            boundary->body.shape->name);
  for (PetscInt a = 0; a < 3; a++)
    PetscCall(SetCurve(scene, rows, columns, value, columns - 1,
                       axis[a] / length * PETSC_PI / 180.0, &boundary->turn));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneReadMotionFile - Reads the motion of body k = 1, 2, ..., whose shape is known, from the file
   of -scene_body_<k>_motion, if it is given; collective. Output: boundary->position and
   boundary->turn; scene->motion_end - the last time of files [s]. */
PetscErrorCode SceneReadMotionFile(Scene *scene, PetscInt k, Boundary *boundary)
{
  static const char *const others[] = {"velocity", "position", "rotation", "place"};
  const PetscInt           dim      = scene->dim;
  char                     name[OPTION_LENGTH], other[OPTION_LENGTH], path[PETSC_MAX_PATH_LEN];
  PetscInt                 rows, columns, bad;
  PetscReal               *value;
  PetscMPIInt              rank;
  OptionRow                row;
  FILE                    *stream = NULL;

  PetscFunctionBegin;
  OptionNumber(&options[FROM_FILE], k, name, &row);
  PetscCall(OptionGetFile(&row, path));
  if (!path[0]) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(others); i++) {
    (void)snprintf(other, sizeof(other), "-scene_body_%" PetscInt_FMT "_%s", k, others[i]);
    PetscCall(OptionsRefuseTogether(name, other, "the file has place and motion of the body"));
  }
  UserCheck(SceneMoves(scene),
            "%s: particles stay where they are, and bodies with them; use -motion lagrangian and "
            "convection",
            name);
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank == 0) stream = fopen(path, "r");
  PetscCall(CsvRead(stream, &rows, &columns, &value, &bad));
  if (stream) (void)fclose(stream);
  UserCheck(rows >= 0, "%s %s: the file cannot be read", name, path);
  UserCheck(!bad, "%s %s: line %" PetscInt_FMT " has other columns, or is not numbers", name, path,
            bad);
  UserCheck(rows > 1 && (columns == dim + 1 || columns == (dim == 2 ? 4 : 8)),
            "%s %s: it has %" PetscInt_FMT " rows of %" PetscInt_FMT
            " numbers; two or more rows of "
            "%s are required",
            name, path, rows, columns, dim == 2 ? "t,x,y[,degrees]" : "t,x,y,z[,ax,ay,az,degrees]");
  UserCheck(value[0] <= 0.0, "%s %s: its first time is %.6g s; that of the start, 0, is required",
            name, path, (double)value[0]);
  PetscCall(PetscStrncpy(boundary->position.option, name, sizeof(boundary->position.option)));
  for (PetscInt a = 0; a < dim; a++)
    PetscCall(SetCurve(scene, rows, columns, value, 1 + a, 1.0, &boundary->position));
  boundary->turn = (Expression){.n = 0};
  PetscCall(PetscStrncpy(boundary->turn.option, name, sizeof(boundary->turn.option)));
  if (columns > dim + 1) PetscCall(SetTurn(scene, rows, columns, value, boundary));
  if (!scene->motion_end || value[(rows - 1) * columns] < scene->motion_end)
    scene->motion_end = value[(rows - 1) * columns];
  PetscCall(PetscFree(value));
  PetscFunctionReturn(PETSC_SUCCESS);
}
