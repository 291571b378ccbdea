#pragma once

#include <cstddef>

#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::inline v1 {

/// Whether labels belong to the scans that they are compared on: which records have a return differs from
/// scan to scan. Nothing is shown where every record has one, as in KITTI; there, numbers of points differ.
class LabelAlignment {
 public:
  void add(const ScanLabels& scan);
  /// Throws InputError where the labels of the result, made by mapless detect, or the true ones are of other
  /// scans.
  void require(const ResultFolder& result) const;

 private:
  std::size_t records_ = 0, misplaced_ = 0;      // of the result
  std::size_t moving_ = 0, moving_nowhere_ = 0;  // by the truth; those without a return
};

}  // namespace mapless
