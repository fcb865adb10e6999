/* Output of a run: probes, the report, snapshots, matrices, progress and the banner. */
#ifndef ISPH_IO_H
#define ISPH_IO_H

#include "isph/forces.h"
#include "isph/schemes.h"

/* Reference data: two columns of a CSV file in the directory of reference data. */
typedef struct {
  PetscInt   n;
  PetscReal *x, *y; /* x ascending */
} ReferenceData;
PetscErrorCode ReferenceDataRead(const char file[], Report *report, ReferenceData *curve);
PetscErrorCode ReferenceDataFree(ReferenceData *curve);

/* A measured quantity in SI units. */
typedef struct {
  char      name[32];
  PetscReal t;         /* [s] */
  PetscReal value;     /* NaN after a diverged run, or if reference data are absent */
  PetscReal reference; /* NaN without reference */
  PetscReal error;     /* relative to the scale; NaN without reference [-] */
} Quantity;

/* The error of the velocity by its gradients, see src/measures/resolution.c. */
typedef struct {
  PetscReal error;           /* in space, root mean square over that of the velocity [-] */
  PetscReal path;            /* by steps along the paths of particles, the same [-] */
  PetscReal x[ISPH_MAX_DIM]; /* place of the largest error of the gradient [m] */
  PetscReal layer;           /* thickness of sheared layers beside rigid parts; 0: none [dx] */
  PetscReal excess; /* |tau - tau_0|/tau of the mean stress tau of a fluid that yields [-] */
} Resolution;

/* Parts of the estimated error, see src/measures/trust.c. */
typedef enum {
  TRUST_SPACE,
  TRUST_OPERATOR,
  TRUST_TIME,
  TRUST_BALANCE,
  TRUST_LAYER,
  TRUST_PARTS
} TrustPart;
typedef struct {
  PetscReal error;             /* of the velocity, root mean square over that of it [-] */
  PetscReal part[TRUST_PARTS]; /* the same by a single cause [-] */
  TrustPart worst;             /* the cause of most of it */
  PetscReal x[ISPH_MAX_DIM];   /* place of the largest error of the gradient [m] */
  PetscReal layer;             /* thickness of sheared layers beside rigid parts; 0: none [dx] */
  PetscReal surface;           /* stress of the free surface over the pressure [-] */
} Trust;

/* Memory of a run, see src/io/machinememory.c. */
typedef struct {
  PetscReal particle, run, machine; /* of a particle; of all ranks on a machine; that it has [B] */
} MachineMemory;
PetscErrorCode MachineMemoryCheck(const Flow *flow, PetscReal particles, MachineMemory *need);

struct Report {
  Quantity *quantity;
  PetscInt  n, capacity;
  PetscReal t;                        /* time of the quantities that are added next [s] */
  char      not_finite[32];           /* first quantity that is not finite; empty: none */
  Trust     trust;                    /* at the last time */
  PetscBool data_absent;              /* a file of the reference data was not found */
  char      file[PETSC_MAX_PATH_LEN]; /* file of all runs; empty: none */
};
PetscErrorCode ReportCreate(Report **report);
PetscErrorCode ReportDestroy(Report **report);
PetscErrorCode ReportAdd(Report *report, const char name[], PetscReal value);
PetscErrorCode ReportAddReference(Report *report, const char name[], PetscReal value,
                                  PetscReal reference, PetscReal scale);
PetscErrorCode ReportAddMissing(Report *report, const char name[]);
PetscErrorCode ReportAddBeyond(Report *report, const char name[], PetscReal residual,
                               PetscReal error);
Quantity      *ReportFind(Report *report, const char name[]);
PetscErrorCode ReportAddError(Report *report, const char name[], PetscReal error);
PetscErrorCode ReportRestore(Report *report, const char name[], const PetscReal row[4]);
PetscErrorCode ReportView(const Report *report, PetscReal wall_seconds, PetscViewer viewer);
PetscErrorCode ReportCheck(const Report *report);
PetscErrorCode ReportFileCheck(const char path[]);
PetscErrorCode ReportWrite(const Flow *flow, const Report *report, PetscReal wall_seconds,
                           const char status[]);

/* Quantities that cases share: error norms against Exact(), and quantities of every report. */
PetscErrorCode NormsExact(const Flow *flow, Report *report);
PetscErrorCode MeasureCommon(const Flow *flow, PetscReal energy, Report *report);
PetscErrorCode ScalarsMeasure(const Flow *flow, Report *report);
PetscErrorCode MeasureFree(const Flow *flow, Report *report);
PetscErrorCode BalancesMeasure(Flow *flow, Report *report);
PetscErrorCode BalancesOfFailed(Flow *flow, Report *report, PetscViewer viewer);
PetscErrorCode BalancesView(const Flow *flow, PetscViewer viewer);

/* Returns the form of the gradient that steps use; NULL if at most snapshots use a gradient. */
static inline const GradientRow *FlowGradient(const Flow *flow)
{
  const unsigned needs = flow->scheme ? flow->scheme->needs : flow->ops->needs;

  return needs & (NEED_PRESSURE | NEED_GRADIENT_U) ? flow->ops->forms.gradient : NULL;
}

PetscErrorCode ResolutionEstimate(const Flow *flow, Resolution *resolution);
PetscErrorCode TrustMeasure(Flow *flow, Report *report);
PetscErrorCode TrustView(const Flow *flow, const Report *report, PetscViewer viewer);

/* Snapshots of the particles for ParaView, option -output. */
typedef struct Snapshots Snapshots;
PetscErrorCode           SnapshotsCreate(const Scene *scene, Snapshots **snapshots);
PetscErrorCode           SnapshotsDestroy(Snapshots **snapshots);
PetscErrorCode           SnapshotsWrite(const Flow *flow, PetscBool final, Snapshots *snapshots);
PetscErrorCode           SnapshotSave(const Flow *flow, const char path[]);
unsigned                 SnapshotsNeeds(const Snapshots *snapshots);
PetscReal                SnapshotsInterval(const Snapshots *snapshots);
PetscInt                 SnapshotsCount(const Snapshots *snapshots);
void                     SnapshotsGet(const Snapshots *snapshots, PetscReal rows[]);
PetscErrorCode           SnapshotsSet(Snapshots *snapshots, PetscInt n, const PetscReal rows[],
                                      PetscInt step);

/* Probes, forces and fluxes during a run, options -probe_point, -probe_line, -probe_flux,
   -probe_forces, -probe_bodies and -probe_volume. */
typedef struct Monitors Monitors;
PetscErrorCode          MonitorsCreate(Flow *flow, Monitors **monitors);
PetscErrorCode          MonitorsDestroy(Monitors **monitors);
PetscErrorCode          MonitorsRestart(PetscReal t, Monitors *monitors);
PetscErrorCode          MonitorsWrite(const Flow *flow, Monitors *monitors);
PetscErrorCode          MonitorsBegin(const Flow *flow, Monitors *monitors);

/* Surfaces of boundaries for ParaView, option -scene_view. */
PetscErrorCode SceneView(const Scene *scene, PetscBool *viewed);

extern const OptionTable ReportOptions, SnapshotOptions, MonitorOptions, ProgressOptions;
extern const Table       ProgressTable;
typedef struct Progress  Progress;
PetscErrorCode           ProgressCreate(Progress **progress);
PetscErrorCode           ProgressDestroy(Progress **progress);
PetscErrorCode           ProgressUpdate(const Flow *flow, PetscBool final, Progress *progress);

PetscErrorCode SpeedView(const Flow *flow, PetscViewer viewer);
PetscErrorCode BannerView(const Flow *flow, const MachineMemory *need, PetscViewer viewer);

#endif
