"""The console command: joins the FMU's export and the hoist's demo, which know nothing of each other."""
