/* The flow of include/isph.h: declarations shared by the files of this folder. */
#ifndef ISPH_FLOW_OF_LIBRARY_H
#define ISPH_FLOW_OF_LIBRARY_H

#include "isph.h"
#include "isph/run.h"

#define LIBRARY_FUNCTIONS 16 /* most functions of a user */

struct IsphFlow_s {
  Run            run;
  PetscOptions   options; /* NULL: PETSc's database */
  ErrorState     errors;  /* of the present call */
  char           message[1200];
  PetscErrorCode failed; /* error of the set-up or of a step, after which there is no other step */
  PetscBool      is_set_up;
  PetscInt       depth; /* of calls within calls: 1 within one */
  PetscBool      idle;  /* set up, but there is no flow: a patch test, a view of the scene, help */
  IsphMonitor    Monitor;
  void          *monitor_ctx;
  FunctionRow    function[LIBRARY_FUNCTIONS];
  char           name[LIBRARY_FUNCTIONS][32];
  Table          functions;
  char           boundary[WALL_NAME]; /* the name that IsphFlowGetBoundary() gave last */
};

/* The state of a flow that a call asks for. */
typedef enum { NEEDS_NOTHING, NEEDS_NO_SETUP, NEEDS_FLOW } CallNeed;

PetscErrorCode CallBegin(IsphFlow f, CallNeed need);
PetscErrorCode CallEnd(IsphFlow f, PetscErrorCode failed);

/* plugin.c */
extern const OptionTable PluginOptions;
PetscErrorCode           PluginsOpen(void);

#endif
