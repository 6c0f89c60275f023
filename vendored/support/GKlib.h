/* What METIS needs of GKlib, in place of its header of the same name, which includes all of GKlib. */
#ifndef ANCF_GKLIB_H
#define ANCF_GKLIB_H

#define _GKLIB_H_ /* metis.h asks for it: the integer types are here */

#include <float.h>
#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>

#include "gk_types.h"
#include "gk_struct.h"
#include "gk_defs.h"
#include "gk_macros.h"
#include "plain_sort.h"
#include "gk_mkblas.h"
#include "gk_mkmemory.h"
#include "gk_mkpqueue.h"
#include "gk_mkrandom.h"
#include "gk_mkutils.h"

/* Where METIS returns to after an error; the macro gk_sigcatch knows these names. */
extern _Thread_local int gk_cur_jbufs;
extern _Thread_local jmp_buf gk_jbufs[];
int gk_sigtrap(void);
int gk_siguntrap(void);
void gk_errexit(int error, char *message, ...);
void errexit(char *message, ...);

int gk_malloc_init(void);
void gk_malloc_cleanup(int show);
void *gk_malloc(size_t size, char *what);
void *gk_realloc(void *old, size_t size, char *what);
void gk_free(void **first, ...);
GK_MKALLOC_PROTO(gk_idx, gk_idx_t)

gk_mcore_t *gk_mcoreCreate(size_t size);
void gk_mcoreDestroy(gk_mcore_t **core, int show);
void *gk_mcoreMalloc(gk_mcore_t *core, size_t size);
void gk_mcorePush(gk_mcore_t *core);
void gk_mcorePop(gk_mcore_t *core);

void gk_randinit(uint64_t seed);
uint32_t gk_randint32(void);
uint64_t gk_randint64(void);
double gk_CPUSeconds(void);

#endif
