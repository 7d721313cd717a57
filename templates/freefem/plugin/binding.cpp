// The plugin `sandglass`: the participant protocol and HDF5 as FreeFEM functions. Only FreeFEM's
// types are dealt with here; the work is done in participant.cpp and hdf5_file.cpp.

#include <AFunction.hpp>
#include <InitFunct.hpp>
#include <RNM.hpp>
#include <cmath>
#include <cstdlib>
#include <error.hpp>
#include <iostream>
#include <memory>

#include "function.hpp"
#include "hdf5_file.hpp"
#include "material_points.hpp"
#include "participant.hpp"

namespace {

using namespace sandglass::freefem;
namespace hdf5_file = sandglass::hdf5_file;
template <class Number>
using Array = hdf5_file::Array<Number>;

// FreeFEM keeps matrices column by column and slices with strides; HDF5 and the protocol want rows.

template <class Number>
Array<Number> packed(const KN_<Number>& vector) {
  Array<Number> array{{static_cast<std::int64_t>(vector.N())}, {}};
  array.values.reserve(static_cast<std::size_t>(vector.N()));
  for (long i = 0; i < vector.N(); ++i) array.values.push_back(vector[i]);
  return array;
}

Array<double> packed(const KNM<double>& matrix) {
  Array<double> array{{matrix.N(), matrix.M()}, {}};
  for (long i = 0; i < matrix.N(); ++i)
    for (long j = 0; j < matrix.M(); ++j) array.values.push_back(matrix(i, j));
  return array;
}

template <class Number>
void unpack(const std::vector<Number>& values, KN<Number>& vector) {
  vector.resize(static_cast<long>(values.size()));
  for (long i = 0; i < vector.N(); ++i) vector[i] = values[static_cast<std::size_t>(i)];
}

void unpack(const Array<double>& array, KNM<double>& matrix, const std::string& name) {
  if (array.shape.size() != 2)
    throw std::runtime_error("'" + name + "' has " + std::to_string(array.shape.size()) +
                             " axes; a real[int,int] has two");
  matrix.resize(array.shape[0], array.shape[1]);
  for (long i = 0; i < matrix.N(); ++i)
    for (long j = 0; j < matrix.M(); ++j)
      matrix(i, j) = array.values[static_cast<std::size_t>(i * matrix.M() + j)];
}

// The participant protocol.

long ready(Stack, string* abilities) {
  participant().ready(*abilities);
  return 0;
}

string* next(Stack stack) {
  const std::string command = telling([] { return participant().next(); });
  if (command.empty()) end(0);  // the orchestrator has gone: nobody is left to answer to
  return text(stack, command);
}

long receive(Stack, string* field, KN<double>* vector) {
  telling([&] { unpack(participant().receive(*field).values, *vector); });
  return vector->N();
}

long receive_rows(Stack, string* field, KNM<double>* matrix) {
  telling([&] { unpack(participant().receive(*field), *matrix, *field); });
  return matrix->N();
}

long send(Stack, string* field, KN_<double> vector) {
  telling([&] { participant().send(*field, packed(vector).values); });
  return vector.N();
}

long send_rows(Stack, string* field, KNM<double>* matrix) {
  telling([&] { participant().send(*field, packed(*matrix)); });
  return matrix->N();
}

long done(Stack) {
  std::cout.flush();
  telling([] { participant().done(); });
  return 0;
}

/// In a participant the orchestrator is told; in a stage's script the log is all there is.
long fail(Stack, string* why) {
  if (std::getenv("SANDGLASS_REPLIES") != nullptr) participant().fail(*why);
  end_with_error(*why);
}

string* path(Stack stack) { return text(stack, participant().path()); }
long window(Stack, long i) { return participant().window(static_cast<int>(i)); }
double time_of(Stack, long i) { return participant().time(static_cast<int>(i)); }

long note(Stack, string* words) {
  participant().note(*words);
  return 0;
}

long saved(Stack, string* name, double seconds) {
  participant().saved(*name, seconds);
  return 0;
}

long finished(Stack) {
  std::cout << "sandglass: finished" << std::endl;
  return 0;
}

double clock_seconds(Stack) { return sandglass::monotonic_seconds(); }

// Files of one's own.

template <class Number>
long read_vector(Stack, string* file, string* dataset, KN<Number>* vector) {
  unpack(hdf5_file::read<Number>(*file, *dataset).values, *vector);
  return vector->N();
}

long read_matrix(Stack, string* file, string* dataset, KNM<double>* matrix) {
  unpack(hdf5_file::read<double>(*file, *dataset), *matrix, *dataset);
  return matrix->N();
}

template <class Number>
long write_vector(Stack, string* file, string* dataset, KN_<Number> vector) {
  hdf5_file::write(*file, *dataset, packed(vector));
  return vector.N();
}

long write_matrix(Stack, string* file, string* dataset, KNM<double>* matrix) {
  hdf5_file::write(*file, *dataset, packed(*matrix));
  return matrix->N();
}

bool exists(Stack, string* file, string* object) { return hdf5_file::exists(*file, *object); }

double attribute(Stack, string* file, string* object, string* name) {
  return hdf5_file::number_attribute(*file, *object, *name);
}

string* attribute_text(Stack stack, string* file, string* object, string* name) {
  return text(stack, hdf5_file::text_attribute(*file, *object, *name));
}

long set_attribute(Stack, string* file, string* object, string* name, double value) {
  hdf5_file::set_attribute(*file, *object, *name, value);
  return 0;
}

long set_attribute_text(Stack, string* file, string* object, string* name, string* value) {
  hdf5_file::set_attribute(*file, *object, *name, *value);
  return 0;
}

bool finite_number(Stack, double value) { return std::isfinite(value); }

// NOLINTNEXTLINE(performance-unnecessary-value-param): FreeFEM hands over views by value
bool finite_vector(Stack, KN_<double> vector) {
  for (long i = 0; i < vector.N(); ++i)
    if (!std::isfinite(vector[i])) return false;
  return true;
}

bool finite_matrix(Stack, KNM<double>* matrix) {
  for (long i = 0; i < matrix->N(); ++i)
    for (long j = 0; j < matrix->M(); ++j)
      if (!std::isfinite((*matrix)(i, j))) return false;
  return true;
}

void add_functions() {
  add("sandglassReady", ready);
  add("sandglassNext", next);
  add("sandglassReceive", receive);
  add("sandglassReceive", receive_rows);
  add("sandglassSend", send);
  add("sandglassSend", send_rows);
  add("sandglassDone", done);
  add("sandglassFail", fail);
  add("sandglassPath", path);
  add("sandglassWindow", window);
  add("sandglassTime", time_of);
  add("sandglassNote", note);
  add("sandglassSaved", saved);
  add("sandglassFinished", finished);
  add("sandglassClock", clock_seconds);
  add("h5read", read_vector<double>);
  add("h5read", read_vector<long>);
  add("h5read", read_matrix);
  add("h5write", write_vector<double>);
  add("h5write", write_vector<long>);
  add("h5write", write_matrix);
  add("h5exists", exists);
  add("h5attribute", attribute);
  add("h5attributetext", attribute_text);
  add("h5setattribute", set_attribute);
  add("h5setattribute", set_attribute_text);
  add("allfinite", finite_number);
  add("allfinite", finite_vector);
  add("allfinite", finite_matrix);
  sandglass::freefem::add_material_points();
}

}  // namespace

LOADFUNC(add_functions)
