#include "arete/store/file.h"
