#include "arete/raster/synthetic.h"
