// The methods with which clients get the pictures that the user's camera has taken of a print. Independent of
// the transport. Event loop's thread only.
#pragma once

#include <filesystem>

#include "daemon/camera/picture_folders.hpp"
#include "daemon/control/control_method.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

class PictureControl {
 public:
  // The spool, in this folder, must outlive the control. The files are read on its thread.
  PictureControl(Spool& spool, const std::filesystem::path& folder) : spool_(spool), folders_(folder) {}

  // Returns all methods by name. The control must outlive them.
  [[nodiscard]] ControlMethods methods();

 private:
  Spool& spool_;
  PictureFolders folders_;
};

}  // namespace contourd
