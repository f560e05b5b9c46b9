#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace uiclink {

/// What SQLite says, with the file.
class SqliteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An open database file. One thread at a time.
class Sqlite {
 public:
  enum class Mode { kReadOnly, kReadWrite, kCreate };
  /// Waits up to ten seconds for what another process has locked. @throws SqliteError.
  Sqlite(const std::filesystem::path& path, Mode mode);
  ~Sqlite();
  Sqlite(const Sqlite&) = delete;
  Sqlite& operator=(const Sqlite&) = delete;

  void Execute(const std::string& sql);

 private:
  friend class SqliteStatement;
  [[noreturn]] void Throw(const std::string& what) const;

  std::string path_;
  sqlite3* database_ = nullptr;
};

/// A statement: parameters are bound in order, rows are stepped through.
class SqliteStatement {
 public:
  SqliteStatement(Sqlite* database, const std::string& sql);
  ~SqliteStatement();
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;

  SqliteStatement& Bind(std::string_view text);
  SqliteStatement& Bind(std::int64_t number);
  SqliteStatement& Bind(double number);  ///< NULL where it is not finite
  SqliteStatement& BindNull();

  bool Step();     ///< false after the last row
  void Execute();  ///< all of it, then Reset
  void Reset();

  int size() const;  ///< columns
  std::string Name(int column) const;
  bool IsNull(int column) const;
  bool IsText(int column) const;
  bool IsInteger(int column) const;
  std::string Text(int column) const;
  std::int64_t Integer(int column) const;
  double Number(int column) const;

 private:
  void Check(int code);

  Sqlite* database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

/// BEGIN IMMEDIATE ... COMMIT; rolled back when it is destroyed without Commit().
class SqliteTransaction {
 public:
  explicit SqliteTransaction(Sqlite* database);
  ~SqliteTransaction();
  SqliteTransaction(const SqliteTransaction&) = delete;
  SqliteTransaction& operator=(const SqliteTransaction&) = delete;
  void Commit();

 private:
  Sqlite* database_;
  bool open_ = true;
};

}  // namespace uiclink
