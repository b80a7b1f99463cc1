#include "arete/render/renderer.h"
