/* Memory, errors and random numbers for METIS, in place of GKlib's memory.c, mcore.c, error.c, random.c and timers.c.

   Nothing here is shared by threads, prints, ends the process or touches signals and random numbers of others, as
   GKlib does.  The random numbers, and hence the orders, are those of every platform. */
#include "metislib.h"

/* ---- errors ---- */

#define MAX_CALLS 4 /* of METIS within one another: one */

_Thread_local int gk_cur_jbufs = -1;
_Thread_local jmp_buf gk_jbufs[MAX_CALLS];

int gk_sigtrap(void) {
  gk_cur_jbufs++;
  return 1;
}

int gk_siguntrap(void) {
  gk_cur_jbufs--;
  return 1;
}

/* Return to the call of METIS, which returns an error. */
void gk_errexit(int error, char *message, ...) {
  (void)message;
  if (gk_cur_jbufs < 0)
    abort();
  longjmp(gk_jbufs[gk_cur_jbufs], error);
}

void errexit(char *message, ...) { gk_errexit(SIGERR, message); }

/* ---- memory: all that is in use is in a list, so that it can be freed after an error ---- */

typedef struct block {
  struct block *before, *after;
} block;

#define HEAD (sizeof(block) > 16 ? sizeof(block) : 16) /* keeps the alignment of malloc */

static _Thread_local block *blocks;

static void *enlist(block *new) {
  if (new == NULL)
    gk_errexit(SIGMEM, NULL);
  new->before = NULL;
  new->after = blocks;
  if (blocks != NULL)
    blocks->before = new;
  blocks = new;
  return (char *)new + HEAD;
}

static block *strike_off(void *pointer) {
  block *old = (block *)((char *)pointer - HEAD);
  if (old->before != NULL)
    old->before->after = old->after;
  else
    blocks = old->after;
  if (old->after != NULL)
    old->after->before = old->before;
  return old;
}

int gk_malloc_init(void) {
  blocks = NULL;
  return 1;
}

void gk_malloc_cleanup(int show) {
  (void)show;
  while (blocks != NULL)
    free(strike_off((char *)blocks + HEAD));
}

void *gk_malloc(size_t size, char *what) {
  (void)what;
  return enlist(size > SIZE_MAX - HEAD ? NULL : malloc(HEAD + size));
}

void *gk_realloc(void *pointer, size_t size, char *what) {
  (void)what;
  if (pointer == NULL)
    return gk_malloc(size, what);
  block *old = strike_off(pointer);
  block *new = size > SIZE_MAX - HEAD ? NULL : realloc(old, HEAD + size);
  if (new == NULL)
    enlist(old); /* to be freed */
  return enlist(new);
}

void gk_free(void **first, ...) {
  va_list others;
  va_start(others, first);
  for (void **each = first; each != LTERM; each = va_arg(others, void **)) {
    if (*each != NULL)
      free(strike_off(*each));
    *each = NULL;
  }
  va_end(others);
}

GK_MKALLOC(gk_idx, gk_idx_t)

/* ---- the stack of work space: a part of one block while it suffices, otherwise blocks of their own ---- */

#define FIRST_PLACES 256 /* on the stack */

gk_mcore_t *gk_mcoreCreate(size_t size) {
  gk_mcore_t *core = gk_malloc(sizeof(gk_mcore_t), NULL);
  memset(core, 0, sizeof(gk_mcore_t));
  core->coresize = size;
  core->core = gk_malloc(size, NULL);
  core->nmops = FIRST_PLACES;
  core->mops = gk_malloc(core->nmops * sizeof(gk_mop_t), NULL);
  return core;
}

void gk_mcoreDestroy(gk_mcore_t **core, int show) {
  (void)show;
  if (*core != NULL)
    gk_free((void **)&(*core)->core, (void **)&(*core)->mops, (void **)core, LTERM);
}

static void push(gk_mcore_t *core, int type, size_t size, void *pointer) {
  if (core->cmop == core->nmops) {
    core->mops = gk_realloc(core->mops, 2 * core->nmops * sizeof(gk_mop_t), NULL);
    core->nmops *= 2;
  }
  core->mops[core->cmop++] = (gk_mop_t){.type = type, .nbytes = (ssize_t)size, .ptr = pointer};
}

void gk_mcorePush(gk_mcore_t *core) { push(core, GK_MOPT_MARK, 0, NULL); }

void *gk_mcoreMalloc(gk_mcore_t *core, size_t size) {
  size = (size + 7) / 8 * 8; /* keeps the alignment of numbers */
  if (size > core->coresize - core->corecpos) {
    push(core, GK_MOPT_HEAP, size, gk_malloc(size, NULL));
    return core->mops[core->cmop - 1].ptr;
  }
  void *pointer = (char *)core->core + core->corecpos;
  core->corecpos += size;
  push(core, GK_MOPT_CORE, size, pointer);
  return pointer;
}

/* Free all since the last mark. */
void gk_mcorePop(gk_mcore_t *core) {
  while (core->cmop > 0) {
    gk_mop_t *last = &core->mops[--core->cmop];
    if (last->type == GK_MOPT_MARK)
      return;
    if (last->type == GK_MOPT_CORE)
      core->corecpos -= (size_t)last->nbytes;
    else
      gk_free(&last->ptr, LTERM);
  }
}

/* ---- random numbers: splitmix64 (Steele, Lea and Flood 2014), the upper 31 bits ---- */

static _Thread_local uint64_t random_state;

void gk_randinit(uint64_t seed) { random_state = seed; }

uint64_t gk_randint64(void) {
  uint64_t z = random_state += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return (z ^ (z >> 31)) >> 1;
}

uint32_t gk_randint32(void) { return (uint32_t)(gk_randint64() >> 32); }

double gk_CPUSeconds(void) { return 0.0; } /* METIS times itself on request only */

/* ---- functions of METIS behind options that are not used here; their files are left out ---- */

static void unused(void) { gk_errexit(SIGERR, NULL); }

void MinCover(idx_t *xadj, idx_t *adjncy, idx_t asize, idx_t bsize, idx_t *cover, idx_t *csize) { unused(); }

idx_t FindSepInducedComponents(ctrl_t *ctrl, graph_t *graph, idx_t *cptr, idx_t *cind) {
  unused();
  return 0;
}

void Change2CNumbering(idx_t nvtxs, idx_t *xadj, idx_t *adjncy) { unused(); }

void Change2FNumberingOrder(idx_t nvtxs, idx_t *xadj, idx_t *adjncy, idx_t *v1, idx_t *v2) { unused(); }
