#include "arete/mesh/surface.h"
