#pragma once

#include <filesystem>
#include <string>

/// The verbs of arete_torture. Each prints its counts and returns the number of faults; each has a
/// negative control, and a control that finds nothing is a fault.
namespace arete::torture {

struct CrashOptions {
  int states = 30000;
  int control_states = 1500;  ///< for each writer without a sync
  int resumes = 40;           ///< crashed disks, a recorded command, on which it is given again
};
int crashsim(const CrashOptions& options);

struct FlipOptions {
  int stride = 1;   ///< every stride-th bit of every file
  int whole = 101;  ///< of those, every whole-th is followed by reading everything
  int threads = 2;
};
int bitflip(const FlipOptions& options);

/// Truncations, also under an open reader, and swapped pages.
int trunc();

struct KillOptions {
  std::filesystem::path arete;  ///< the program
  int points = 200;
  int readers = 4;
  int size = 1025;  ///< posts a side
};
int kill9(const KillOptions& options);

}  // namespace arete::torture
