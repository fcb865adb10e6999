/*
  PLY files: a header that lists elements and their properties, then the elements as text or as
  binary numbers of either order of bytes. Points have x, y, z; faces a list of points.
*/
#include "mesh.h"
#include <math.h>
#include <stdint.h>
#include <string.h>

#define MOST_PROPERTIES 64
#define MOST_ELEMENTS   16
#define MOST_CORNERS    64

/* Kinds of numbers, by both of their names. */
static const struct {
  const char *name, *other;
  PetscInt    bytes;
  char        kind; /* signed, unsigned, or floating */
} types[] = {
    {"char", "int8", 1, 's'},     {"uchar", "uint8", 1, 'u'},    {"short", "int16", 2, 's'},
    {"ushort", "uint16", 2, 'u'}, {"int", "int32", 4, 's'},      {"uint", "uint32", 4, 'u'},
    {"float", "float32", 4, 'f'}, {"double", "float64", 8, 'f'},
};

/* A property; of lists, `count` is the type of the length. */
typedef struct {
  char     name[32];
  PetscInt type, count; /* count: -1 for a single number */
} Property;

typedef struct {
  char     name[32];
  PetscInt n, properties;
  Property property[MOST_PROPERTIES];
} Element;

typedef struct {
  PetscBool text, big; /* big: the first byte is the highest */
  PetscInt  n;
  Element   element[MOST_ELEMENTS];
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

static void ReadElement(MeshFile *file, Header *h)
{
  PetscReal n = -1.0;

  if (h->n == MOST_ELEMENTS) MeshFail(file, "its header has over %d elements", MOST_ELEMENTS);
  if (*file->fault) return;
  Word(file, h->element[h->n].name);
  if (!MeshNumber(file, &n) || !(n >= 0.0 && n <= (PetscReal)file->length))
    MeshFail(file, "its header has %g of '%s', more than its bytes, or none", (double)n,
             h->element[h->n].name);
  else h->element[h->n++].n = (PetscInt)n;
}

static void ReadProperty(MeshFile *file, Header *h)
{
  Element  *e = h->n ? &h->element[h->n - 1] : NULL;
  Property *p;

  if (!e || e->properties == MOST_PROPERTIES)
    MeshFail(file, "its header has a property of no element, or over %d", MOST_PROPERTIES);
  if (*file->fault) return;
  p        = &e->property[e->properties++];
  p->count = MeshWord(file, "list") ? Type(file) : -1;
  p->type  = Type(file);
  Word(file, p->name);
}

static void ReadHeader(MeshFile *file, Header *h)
{
  PetscBool format = PETSC_FALSE;

  MeshSkipLine(file);
  while (!*file->fault && *file->at && !MeshWord(file, "end_header")) {
    if (MeshWord(file, "format")) {
      format  = PETSC_TRUE;
      h->text = MeshWord(file, "ascii");
      h->big  = MeshWord(file, "binary_big_endian");
      if (!h->text && !h->big && !MeshWord(file, "binary_little_endian"))
        MeshFail(file, "its format is none of ascii, binary_little_endian, binary_big_endian");
    } else if (MeshWord(file, "element")) {
      ReadElement(file, h);
    } else if (MeshWord(file, "property")) {
      ReadProperty(file, h);
    }
    MeshSkipLine(file);
  }
  if (!format || !*file->at) MeshFail(file, "its header has no format or no 'end_header'");
  MeshSkipLine(file);
}

/* Reads one number of the body of a file. */
static PetscReal Number(MeshFile *file, const Header *h, PetscInt type)
{
  const PetscInt bytes = types[type].bytes;
  uint64_t       word  = 0;
  PetscReal      x     = 0.0;
  float          single;

  if (*file->fault) return 0.0;
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
  if (bytes == 8) {
    memcpy(&x, &word, sizeof(x));
    return x;
  }
  {
    const uint32_t half = (uint32_t)word;

    memcpy(&single, &half, sizeof(single));
  }
  return single;
}

/* Reads an item of an element. Output: x - coordinates of a point; corner - n of a face */
static void ReadItem(MeshFile *file, const Header *h, const Element *e, PetscReal x[3], PetscInt *n,
                     PetscInt corner[MOST_CORNERS])
{
  for (PetscInt k = 0; k < e->properties; k++) {
    const Property *p     = &e->property[k];
    const PetscReal count = p->count < 0 ? 1.0 : Number(file, h, p->count);
    const PetscBool face  = !strcmp(p->name, "vertex_indices") || !strcmp(p->name, "vertex_index");

    if (!(count >= 0.0 && count <= (PetscReal)file->length) || (face && count > MOST_CORNERS))
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
    const Element  *e    = &h.element[k];
    const PetscBool face = !strcmp(e->name, "face"), point = !strcmp(e->name, "vertex");

    for (PetscInt q = 0; q < e->n && !*file->fault; q++) {
      PetscReal x[3] = {NAN, NAN, NAN};
      PetscInt  n    = 0, corner[MOST_CORNERS];

      ReadItem(file, &h, e, x, &n, corner);
      if (*file->fault) break;
      if (point) MeshAdd(&points, 3, x);
      if (*points.fault) MeshFail(file, "%s", points.fault);
      if (face) MeshAddPolygon(file, n, corner, points.n / 3, points.number);
    }
  }
  (void)PetscFree(points.number);
}
