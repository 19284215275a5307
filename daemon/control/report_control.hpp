// The method with which clients read the report of a print that has ended. Independent of the transport.
// Event loop's thread only.
#pragma once

#include "daemon/control/control_method.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

class ReportControl {
 public:
  using Json = ControlMethod::Json;

  // The spool must outlive the control. The files are read on its thread.
  explicit ReportControl(Spool& spool) : spool_(spool) {}

  // Returns the method by its name. The control must outlive it.
  [[nodiscard]] ControlMethods methods();

 private:
  Spool& spool_;
};

}  // namespace contourd
