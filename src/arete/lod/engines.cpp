#include "arete/lod/engine.h"
