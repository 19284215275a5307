// The spool's four folders, and what a job's files are called in each. Looks at the disk and changes nothing.
// Thread-safe (no state that changes).
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

  // A folder of any name that is not hidden, but not one called like a model: that is refused as what it is
  // not.
  [[nodiscard]] bool is_plate(SpoolFolder where, const std::string& file) const;
  // The files of a model, its ticket with it if there is one; or a plate's folder.
  [[nodiscard]] JobFiles files_of(SpoolFolder where, const std::string& file) const;
  // What the files of a job like that are called under this name.
  [[nodiscard]] JobFiles named(SpoolFolder where, const std::string& name, const JobFiles& like) const;

  // A name that no job in printing/, done/ or failed/ has: `stem`, shortened if need be, with a number behind
  // it if need be.
  [[nodiscard]] std::string unused_name(const std::string& stem) const;
  // The same for incoming/, where a ticket that is there belongs to another.
  [[nodiscard]] JobFiles unused_in_incoming(const JobFiles& like) const;
  // In incoming/, under a name that no job has in any of the four.
  [[nodiscard]] JobFiles unused_anywhere(const JobFiles& like) const;

  // Whether there is another model that the ticket of this one is meant for too: "part.STL" beside
  // "part.stl".
  [[nodiscard]] bool shares_ticket(const JobFiles& job) const;
  // The models in incoming/ that a ticket of this name is meant for.
  [[nodiscard]] std::vector<std::filesystem::path> models_of_ticket(const std::string& ticket) const;

 private:
  [[nodiscard]] bool is_name_used(const std::string& name) const;
  [[nodiscard]] bool is_used_in_incoming(const std::string& name, const JobFiles& like) const;

  std::filesystem::path root_;
};

// Whether a file in incoming/ is a model, by its name.
[[nodiscard]] bool is_model_name(const std::string& file);

// The name of the job that a model or a plate's folder in incoming/ becomes, but for a number behind it.
[[nodiscard]] std::string job_name_of(const std::string& file);

// Why something in the spool cannot be written, for its owner.
[[nodiscard]] std::string why_not_written(const std::error_code& code);

}  // namespace contourd
