/* The integer types that amd.h asks for, in place of the header of the same name. */
#ifndef ANCF_SUITESPARSE_CONFIG_H
#define ANCF_SUITESPARSE_CONFIG_H

#include <stdint.h>

#define SuiteSparse_long int64_t
#define SuiteSparse_long_max INT64_MAX
#define SuiteSparse_long_id "%ld"

#endif
