// The models that a job's ticket names and their files: all files are opened, checked against the available
// memory, then read. A plate may name a file many times: the file is read once, and models that are turned
// and scaled alike are built once. An archive of several models is a plate of them. Thread-safe (no shared
// state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/prepare/job_memory.hpp"
#include "daemon/prepare/model_file.hpp"
#include "daemon/spool/job_files.hpp"
#include "daemon/system/memory_room.hpp"

namespace contourd {

// A model of a job's ticket.
struct NamedModel {
  ModelTicket ticket;
  std::string name;  // as messages name it
  std::string path;  // for reports: in the plate's folder, then in an archive; empty: the job's only file
  std::size_t file;  // index of its file
  // Index of the first model that is made from the same file, turned and scaled alike; its own if there is
  // none before.
  std::size_t made_as;
};

class JobContent {
 public:
  // Opens the files. `unsupported`: of an archive's models with supports and without, those without are
  // meant. Throws JobRefused.
  JobContent(const JobFiles& files, const JobTicket& ticket, bool unsupported);

  [[nodiscard]] const std::vector<NamedModel>& models() const { return models_; }
  // True for a plate, and for an archive of several models.
  [[nodiscard]] bool is_plate() const { return is_plate_; }
  // True for an archive of several models, some of which may be left out.
  [[nodiscard]] bool is_archive_plate() const { return is_plate_ && !files_of_job_.plate; }
  // Returns the choices made in archives, a sentence each.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  // Returns the archive if the job's only file holds finished layers; null for models.
  [[nodiscard]] const SlicedArchive* sliced() const { return files_.front().sliced(); }
  // Returns these layers. Valid after read().
  [[nodiscard]] const FinishedLayers& finished_layers() const { return finished_; }
  // Removes a model, whose facets are taken already. REQUIRES: is_archive_plate(); it is not the only one.
  void leave_out(std::size_t model);
  // True if no earlier model is made from the same file.
  [[nodiscard]] bool is_first_of_file(std::size_t model) const;

  // Reads all files. Blocks. Throws JobRefused; JobTooLarge if there is not enough memory for the job, before
  // any file is read. The box around finished layers becomes the job's only model, where they light the
  // plate. Reads only a part of these layers if a stop was requested.
  void read(const DisplayGeometry& display, const MemoryRoom& room, const std::stop_token& stop);
  // True if there is memory to repair this many facets beside the job.
  [[nodiscard]] bool has_room_to_repair(std::size_t facets) const;
  // The next three functions check needs that are known only after reading. They throw JobTooLarge if the job
  // would not fit into the memory that was available before anything was read.
  // Checks the memory to repair these facets of a model.
  void require_room_to_repair(std::span<const Facet> facets);
  // Checks the memory to hollow a model of this size with cells as small as a pixel.
  void require_room_to_hollow(const Bounds& model, Millimeters pixel) const;
  // Checks the memory to generate supports for the models.
  void require_room_for_supports(std::span<const PlateModel> models, const DisplayGeometry& display) const;
  // Checks the memory to compute masks of the models. `moved`: their contours are moved (see Compensation).
  // `more`: memory to dim undersides and to split exposures, in bytes.
  void require_room_for_masks(std::span<const PlateModel> models, bool moved, std::uint64_t more) const;

  [[nodiscard]] std::string_view format(std::size_t file) const { return files_[file].outline().format; }
  // Returns the warnings from reading a file. Valid after read().
  [[nodiscard]] const std::vector<std::string>& warnings(std::size_t file) const {
    return read_[file].warnings;
  }
  // True if the model was chosen because it carries supports: see ChosenModel.
  [[nodiscard]] bool is_supported(std::size_t file) const { return files_[file].is_supported(); }
  // Returns the unit that a file names. Valid after read().
  [[nodiscard]] std::optional<LengthUnit> unit(std::size_t file) const { return read_[file].unit; }
  // True if a file says that it has more facets than it holds. Valid after read().
  [[nodiscard]] bool lacks_facets(std::size_t file) const { return read_[file].lacks_facets; }
  // True if the shape suggests that the file's y axis points up. Valid after read().
  [[nodiscard]] bool y_is_up(std::size_t file) const { return read_[file].y_is_up; }
  // Returns the facets of the model's file. Call it in the models' order, only for models whose `made_as` is
  // their own index: the last call for a file takes the facets over, earlier ones copy them.
  [[nodiscard]] std::vector<Facet> take_facets(std::size_t model);

 private:
  // The models of a ticket's file, in files_.
  struct OpenedFile {
    std::string name;                  // as the ticket has it
    std::vector<std::string> entries;  // as the ticket has them
    std::size_t first, count;
  };

  void add(const ModelTicket& ticket, bool unsupported);
  [[nodiscard]] OpenedFile open(const ModelTicket& ticket, bool unsupported);
  void add_model(const ModelTicket& ticket, std::size_t file);
  [[nodiscard]] Model read_layers(const DisplayGeometry& display, const std::stop_token& stop);

  JobFiles files_of_job_;
  bool is_plate_;
  std::vector<std::string> notes_;
  std::vector<OpenedFile> opened_;
  std::vector<NamedModel> models_;
  std::vector<ModelFile> files_;
  std::vector<FileToRead> to_read_;  // outlines, by file
  std::vector<Model> read_;          // by file
  FinishedLayers finished_;
  std::uint64_t needed_ = 0;     // bytes
  std::uint64_t repairing_ = 0;  // bytes in addition, for the largest repair
  MemoryRoom room_;              // before reading
};

}  // namespace contourd
