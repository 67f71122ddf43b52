namespace lamella {}  // namespace lamella
