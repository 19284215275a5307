// The print that a power cut, a crash or a kill ended in the middle, while its part hangs on the plate. A
// value.
#pragma once

#include <optional>
#include <string>

#include "daemon/print/print_plan.hpp"
#include "daemon/progress/progress_record.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

struct InterruptedPrint {
  JobFiles files;  // in printing/
  JobProgress progress;
  bool is_latest = true;       // false if the latest copy of the record is damaged
  bool ended_reading = false;  // a process ended while it read the job to continue its print
  std::string trouble{};       // why the print could not go on when a user resumed it; else empty
};

// Returns where the print was: "in layer 12 of 200, before or during its light (0.600 mm above the film)".
[[nodiscard]] std::string describe(const JobProgress& progress);

// Returns why the print cannot go on, in a sentence; empty if it can. `homes_upwards`: see ZAxis. `trusted`:
// the user trusts the recorded height.
[[nodiscard]] std::string why_not_resumable(const InterruptedPrint& interrupted, bool homes_upwards,
                                            bool trusted);
// Returns how the user can continue the print, or that it cannot go on, for a sentence.
[[nodiscard]] std::string describe_way_on(const InterruptedPrint& interrupted, bool homes_upwards);
// Notes that the plate was moved by hand by this distance, or by an unknown one: the print does not go on.
void move_by_hand(PrintProgress& print, std::optional<Nanometers> distance);
// Returns the point from which the print goes on. A layer that may lack light is lit again, in full: resin
// forgets within seconds what light it had.
[[nodiscard]] ResumePoint resume_point(const JobProgress& progress, bool trusted);
// Returns what trusting the recorded height assumes, in a sentence.
[[nodiscard]] std::string describe_trust(const JobProgress& progress, double microsteps_per_mm);
// Returns what the point where the print goes on does to the part, in a sentence. `penetration`: Dp of the
// resin's working curve, if it was measured.
[[nodiscard]] std::string describe_seam(const JobProgress& progress, std::optional<Micrometers> penetration);

}  // namespace contourd
