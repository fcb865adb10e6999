/*
  Values of the last time T, and their mean by the trapezoidal rule, for probes and forces at fixed
  places. All ranks hold the same values.
*/
#include "monitors.h"

/* WindowFree - Empties a window; not collective */
PetscErrorCode WindowFree(Window *window)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(window->row));
  window->count = window->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes the values of times before `from`. */
static PetscErrorCode WindowForget(PetscReal from, Window *w)
{
  PetscInt first = 0;

  PetscFunctionBegin;
  while (first < w->count && w->row[first * (1 + w->n)] < from) first++;
  if (first == 0) PetscFunctionReturn(PETSC_SUCCESS);
  w->count -= first;
  PetscCall(PetscArraymove(w->row, w->row + first * (1 + w->n), w->count * (1 + w->n)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends a row with a time and n values. */
static PetscErrorCode WindowAppend(PetscReal t, const PetscReal value[], Window *w)
{
  PetscFunctionBegin;
  if (w->count == w->capacity) {
    w->capacity = 2 * w->capacity + 16;
    PetscCall(
        PetscRealloc(sizeof(PetscReal) * (size_t)(w->capacity * (1 + w->n)), (void **)&w->row));
  }
  w->row[w->count * (1 + w->n)] = t;
  PetscCall(PetscArraycpy(&w->row[w->count * (1 + w->n) + 1], value, w->n));
  w->count++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes a window for n values of a time; one of another number is emptied. */
static PetscErrorCode WindowSize(PetscInt n, Window *w)
{
  PetscFunctionBegin;
  if (w->n == n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WindowFree(w));
  w->n = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the means over the times of a window; those of a single time are its values. */
static void WindowMean(const Window *w, PetscReal value[])
{
  const PetscReal *row    = w->row;
  const PetscInt   width  = 1 + w->n;
  const PetscReal  length = row[(w->count - 1) * width] - row[0];

  if (length <= 0.0) return;
  for (PetscInt q = 0; q < w->n; q++) value[q] = 0.0;
  for (PetscInt k = 1; k < w->count; k++) {
    const PetscReal *before = &row[(k - 1) * width], *after = &row[k * width];
    const PetscReal  weight = 0.5 * (after[0] - before[0]) / length;

    for (PetscInt q = 1; q <= w->n; q++) value[q - 1] += weight * (before[q] + after[q]);
  }
}

/*
  MonitorMean - Adds values to a window of a monitor, and replaces them by their means over the last
  time monitor->T

  Not collective. The window begins at its first time that is at least t - T. The pressure before
  the first step is not a pressure of the flow, and enters no mean.

  Input Parameters:
+ k - index of the window
- n - number of values

  Input/Output Parameters:
+ value   - in: present values; out: their means; unchanged without windows
- monitor - the monitor
*/
PetscErrorCode MonitorMean(const Clock *clock, PetscInt k, PetscInt n, PetscReal value[],
                           Monitor *monitor)
{
  const PetscReal t = clock->t;

  PetscFunctionBegin;
  if (!monitor->n_windows || clock->step == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WindowSize(n, &monitor->window[k]));
  PetscCall(WindowForget(t - monitor->T * (1.0 + 1e-9), &monitor->window[k]));
  PetscCall(WindowAppend(t, value, &monitor->window[k]));
  WindowMean(&monitor->window[k], value);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WindowPack - Copies a window to an array, if that is not NULL; returns the number of values */
PetscInt WindowPack(const Window *window, PetscReal values[])
{
  const PetscInt n = window->count * (1 + window->n);

  if (!values) return 2 + n;
  values[0] = (PetscReal)window->n;
  values[1] = (PetscReal)window->count;
  for (PetscInt k = 0; k < n; k++) values[2 + k] = window->row[k];
  return 2 + n;
}

/* WindowUnpack - Restores a window from an array of `room` values; `used` counts the values that it
   took. A window stays empty if the array is too short, as in a damaged file. */
PetscErrorCode WindowUnpack(PetscInt room, const PetscReal values[], Window *window, PetscInt *used)
{
  const PetscReal n = room < 2 ? 0.0 : values[0], count = room < 2 ? 0.0 : values[1];

  PetscFunctionBegin;
  *used = room;
  if (!(n >= 0.0 && count >= 0.0 && 2.0 + count * (1.0 + n) <= (PetscReal)room))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WindowSize((PetscInt)n, window));
  *used = 2;
  for (PetscInt k = 0; k < (PetscInt)count; k++, *used += 1 + window->n)
    PetscCall(WindowAppend(values[*used], &values[*used + 1], window));
  PetscFunctionReturn(PETSC_SUCCESS);
}
