/*
  PLY files: a header that lists elements and their properties, then the elements as text or as
  binary numbers of either order of bytes. Points have x, y, z; faces a list of points.
*/
#include "mesh.h"
#include <math.h>
#include <stdint.h>
#include <string.h>

#define MOST 64 /* properties of all elements, and corners of a face */

/* Kinds of numbers by both of their names, their bytes, and signed, unsigned or floating. */
static const struct {
  const char *name, *other;
  PetscInt    bytes;
  char        kind;
} types[] = {
    {"char", "int8", 1, 's'},     {"uchar", "uint8", 1, 'u'},    {"short", "int16", 2, 's'},
    {"ushort", "uint16", 2, 'u'}, {"int", "int32", 4, 's'},      {"uint", "uint32", 4, 'u'},
    {"float", "float32", 4, 'f'}, {"double", "float64", 8, 'f'},
};

/* A property, or an element, which is followed by its properties. */
typedef struct {
  char     name[32];
  PetscInt type, count; /* of numbers, of the length of a list; count -1: no list */
  PetscInt items;       /* of an element; -1: a property */
} Entry;

typedef struct {
  PetscBool text, big; /* big: the first byte is the highest */
  PetscInt  n;
  Entry     entry[MOST];
} Header;

/* Reads a word of the header without blanks. */
static void Word(MeshFile *file, char word[32])
{
  size_t n;

  file->at += strspn(file->at, " \t");
  n = strcspn(file->at, " \t\r\n");
  (void)PetscStrncpy(word, file->at, PetscMin(n + 1, (size_t)32));
  file->at += n;
}

static PetscInt Type(MeshFile *file)
{
  char word[32];

  Word(file, word);
  for (PetscInt k = 0; k < (PetscInt)PETSC_STATIC_ARRAY_LENGTH(types); k++)
    if (!strcmp(word, types[k].name) || !strcmp(word, types[k].other)) return k;
  MeshFail(file, "its header has the type '%s' of a number; float, int, uchar, ... are known",
           word);
  return 0;
}

static void ReadHeader(MeshFile *file, Header *h)
{
  PetscBool format = PETSC_FALSE;

  for (MeshSkipLine(file); *file->at && !MeshWord(file, "end_header"); MeshSkipLine(file)) {
    Entry    *e = &h->entry[h->n];
    PetscReal n = -1.0;

    if (*file->fault) return;
    if (MeshWord(file, "format")) {
      format  = PETSC_TRUE;
      h->text = MeshWord(file, "ascii");
      h->big  = MeshWord(file, "binary_big_endian");
      if (!h->text && !h->big && !MeshWord(file, "binary_little_endian"))
        MeshFail(file, "its format is none of ascii, binary_little_endian, binary_big_endian");
      continue;
    }
    if (h->n == MOST) MeshFail(file, "its header has over %d properties", MOST);
    else if (MeshWord(file, "element")) {
      Word(file, e->name);
      if (!MeshNumber(file, &n) || !(n >= 0.0 && n <= (PetscReal)file->length))
        MeshFail(file, "its header has %g of '%s', more than its bytes, or none", (double)n,
                 e->name);
      else e->items = (PetscInt)n;
      h->n++;
    } else if (MeshWord(file, "property")) {
      if (h->n == 0) MeshFail(file, "its header has a property of no element");
      e->count = MeshWord(file, "list") ? Type(file) : -1;
      e->type  = Type(file);
      e->items = -1;
      Word(file, e->name);
      h->n++;
    }
  }
  if (!format || !*file->at) MeshFail(file, "its header has no format or no 'end_header'");
  MeshSkipLine(file);
}

/* Reads one number of the body of a file. */
static PetscReal Number(MeshFile *file, const Header *h, PetscInt type)
{
  const PetscInt bytes = types[type].bytes;
  uint64_t       word  = 0;
  uint32_t       half;
  PetscReal      x = 0.0;
  float          single;

  if (h->text) {
    if (!MeshNumber(file, &x)) MeshFail(file, "a number is required at '%.20s'", file->at);
    return x;
  }
  if (file->at + bytes > file->text + file->length) {
    MeshFail(file, "it ends before its elements do: a part of it is missing");
    return 0.0;
  }
  for (PetscInt k = 0; k < bytes; k++)
    word |= (uint64_t)(unsigned char)file->at[h->big ? bytes - 1 - k : k] << 8 * k;
  file->at += bytes;
  if (types[type].kind == 'u') return (PetscReal)word;
  if (types[type].kind == 's')
    return (PetscReal)((int64_t)(word << (64 - 8 * bytes)) >> (64 - 8 * bytes));
  half = (uint32_t)word;
  memcpy(&x, &word, sizeof(x));
  memcpy(&single, &half, sizeof(single));
  return bytes == 8 ? x : single;
}

/* Reads an item of an element. Output: x - coordinates of a point; corner - n of a face */
static void ReadItem(MeshFile *file, const Header *h, PetscInt element, PetscReal x[3], PetscInt *n,
                     PetscInt corner[MOST])
{
  for (PetscInt k = element + 1; k < h->n && h->entry[k].items < 0; k++) {
    const Entry    *p     = &h->entry[k];
    const PetscReal count = p->count < 0 ? 1.0 : Number(file, h, p->count);
    const PetscBool face  = !strcmp(p->name, "vertex_indices") || !strcmp(p->name, "vertex_index");

    if (!(count >= 0.0 && count <= (PetscReal)file->length) || (face && count > MOST))
      MeshFail(file, "a list has %g numbers", (double)count);
    for (PetscInt q = 0; q < count && !*file->fault; q++) {
      const PetscReal value = Number(file, h, p->type);

      if (p->count < 0 && !p->name[1] && p->name[0] >= 'x' && p->name[0] <= 'z')
        x[p->name[0] - 'x'] = value;
      if (face) corner[q] = value >= 0.0 && value < 1e9 ? (PetscInt)value : -1;
    }
    if (face) *n = (PetscInt)count;
  }
}

/* MeshReadPly - Reads the faces of a PLY file; not collective */
void MeshReadPly(MeshFile *file)
{
  MeshFile points = {.n = 0};
  Header   h      = {.n = 0};

  ReadHeader(file, &h);
  for (PetscInt k = 0; k < h.n; k++) {
    const PetscBool face  = !strcmp(h.entry[k].name, "face"),
                    point = !strcmp(h.entry[k].name, "vertex");

    for (PetscInt q = 0; q < h.entry[k].items && !*file->fault; q++) {
      PetscReal x[3] = {NAN, NAN, NAN};
      PetscInt  n    = 0, corner[MOST];

      ReadItem(file, &h, k, x, &n, corner);
      if (*file->fault) break;
      if (point) MeshAdd(&points, 3, x);
      if (*points.fault) MeshFail(file, "%s", points.fault);
      if (face) MeshAddPolygon(file, n, corner, points.n / 3, points.number);
    }
  }
  (void)PetscFree(points.number);
}
