/* The motion of bodies in a step: their poses follow the given velocity, and wall particles move
   with them. Particles of the fluid then keep off the new surfaces. */
#include "isph/motion.h"

#define NODES 3   /* of the rule of Gauss in a step */
#define DEPTH 0.5 /* to which a body may enter another [dx] */

static const PetscReal gauss[NODES][2] = {
    {0.1127016653792583, 5.0 / 18.0}, {0.5, 8.0 / 18.0}, {0.8872983346207417, 5.0 / 18.0}};

static void Advance(const Scene *scene, PetscInt side, PetscReal t, PetscReal dt, Pose *pose)
{
  for (PetscInt k = 0; k < NODES; k++) {
    PetscReal u[ISPH_MAX_DIM], spin[ISPH_MAX_DIM];

    BodyMotion(scene, side, t + gauss[k][0] * dt, u, spin);
    for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
      pose->x[a] += gauss[k][1] * dt * u[a];
      spin[a] *= gauss[k][1] * dt;
    }
    PoseRotate(spin, pose);
  }
  BodyGivenPose(scene, side, t + dt, pose);
  BodyMotion(scene, side, t + dt, pose->u, pose->spin);
}

/* Moves the wall particles of bodies that move from their poses `before` to the present ones. */
static void MoveWalls(const Scene *scene, const Pose before[], Particles *p)
{
  for (PetscInt i = p->n_fluid; i < p->n_fluid + p->n_wall; i++) {
    const PetscInt side                 = (PetscInt)p->side[i];
    const Body    *body                 = BoundaryBody(scene, side);
    PetscReal      normal[ISPH_MAX_DIM] = {0.0}, arm[ISPH_MAX_DIM] = {0.0}, from[ISPH_MAX_DIM];
    Body           old;

    if (!scene->boundary[side].moves) continue;
    old      = *body;
    old.pose = (Pose *)&before[side - SceneBodySide(scene, 0)];
    for (PetscInt a = 0; a < p->dim; a++) {
      normal[a] = p->normal[a][i];
      from[a]   = p->x[a][i];
    }
    BodyArm(scene, &old, from, arm);
    for (PetscInt a = 0; a < p->dim; a++) p->x[a][i] -= arm[a]; /* the centre of this image */
    PoseTurn(old.pose, PETSC_TRUE, arm);
    PoseTurn(body->pose, PETSC_FALSE, arm);
    PoseTurn(old.pose, PETSC_TRUE, normal);
    PoseTurn(body->pose, PETSC_FALSE, normal);
    for (PetscInt a = 0; a < p->dim; a++) {
      p->x[a][i] += body->pose->x[a] - old.pose->x[a] + arm[a];
      p->normal[a][i] = normal[a];
    }
  }
}

/* BodiesMove - Moves bodies, and their wall particles, to the end of the step; refuses bodies that
   overlap there; collective */
PetscErrorCode BodiesMove(Flow *flow)
{
  const Scene *scene = flow->scene;
  Pose        *before;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(scene->n_bodies, &before));
  PetscCall(PetscArraycpy(before, scene->pose, scene->n_bodies));
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    const PetscInt side = SceneBodySide(scene, k);

    if (scene->boundary[side].free) FreeBodyMove(flow, k);
    else if (scene->boundary[side].moves)
      Advance(scene, side, flow->clock->t, flow->clock->dt, &scene->pose[k]);
  }
  PetscCall(SceneCheckMoved(scene, flow->clock->t + flow->clock->dt, DEPTH * scene->dx));
  MoveWalls(scene, before, flow->particles);
  PetscCall(ParticlesHaloComponents(flow->particles, flow->particles->normal));
  PetscCall(PetscFree(before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* BodiesRegister - Adds the poses of bodies that move, and the share of the fluid in solids, to the
   memory of the run. Collective. Undo, checkpoints and restarts then have them. */
PetscErrorCode BodiesRegister(const Scene *scene, Scheme *scheme)
{
  const PetscInt size  = (PetscInt)(sizeof(Pose) / sizeof(PetscReal));
  BalanceSheet  *sheet = &scheme->sheet;

  PetscFunctionBegin;
  if (!scene->pose) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      MemoryAddReals(&scheme->memory, "poses", size * scene->n_bodies, (PetscReal *)scene->pose));
  PetscCall(MemoryAddReal(&scheme->memory, "fluid_in_solids", &sheet->value[BALANCE_SOLID]));
  PetscCall(MemoryAddReal(&scheme->memory, "fluid_in_solids_t", &sheet->t[BALANCE_SOLID]));
  PetscCall(MemoryAddInt(&scheme->memory, "solids", &sheet->applies[BALANCE_SOLID]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
