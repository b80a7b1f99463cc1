#include "arete/proof/verify.h"
