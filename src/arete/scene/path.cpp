#include "arete/scene/path.h"
