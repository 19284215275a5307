// The spool's four folders and the names of a job's files in them. Reads the disk and changes nothing.
// Thread-safe (immutable).
#pragma once

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "daemon/spool/job_files.hpp"

namespace contourd {

enum class SpoolFolder { Incoming, Printing, Done, Failed };

class SpoolFolders {
 public:
  explicit SpoolFolders(std::filesystem::path root);

  [[nodiscard]] const std::filesystem::path& root() const { return root_; }
  [[nodiscard]] std::filesystem::path path(SpoolFolder folder) const;

  // True if the path is a folder that is neither hidden nor named like a model. A folder named like a model
  // is later refused as a model that cannot be read.
  [[nodiscard]] bool is_plate(SpoolFolder where, const std::string& file) const;
  // Returns the files of a model, with its ticket if that exists, or a plate's folder.
  [[nodiscard]] JobFiles files_of(SpoolFolder where, const std::string& file) const;
  // Returns the paths in a folder for the files of the job `like` under another job name.
  [[nodiscard]] JobFiles named(SpoolFolder where, const std::string& name, const JobFiles& like) const;

  // Returns a name that no job in printing/, done/ or failed/ has: `stem`, shortened and followed by a number
  // if necessary.
  [[nodiscard]] std::string unused_name(const std::string& stem) const;
  // Returns paths in incoming/ whose name neither a job nor a ticket there has.
  [[nodiscard]] JobFiles unused_in_incoming(const JobFiles& like) const;
  // Returns paths in incoming/ whose name no job has in any of the four folders.
  [[nodiscard]] JobFiles unused_anywhere(const JobFiles& like) const;

  // True if the job's ticket in incoming/ belongs to another model too, as with "part.STL" beside "part.stl".
  [[nodiscard]] bool shares_ticket(const JobFiles& job) const;
  // Returns the models in incoming/ to which a ticket of this name belongs.
  [[nodiscard]] std::vector<std::filesystem::path> models_of_ticket(const std::string& ticket) const;

 private:
  [[nodiscard]] bool is_name_used(const std::string& name) const;
  [[nodiscard]] bool is_used_in_incoming(const std::string& name, const JobFiles& like) const;

  std::filesystem::path root_;
};

// True if a file in incoming/ is a model by its name.
[[nodiscard]] bool is_model_name(const std::string& file);

// Returns the job name of a model or a plate's folder in incoming/, without the number that may be appended.
[[nodiscard]] std::string job_name_of(const std::string& file);

// Returns a message for a user that says why something in the spool cannot be written.
[[nodiscard]] std::string why_not_written(const std::error_code& code);

}  // namespace contourd
